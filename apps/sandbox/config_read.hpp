// config_read.hpp: from TOML text to a Config. Every fault (syntax, unknown key, wrong type, out of range) is added
// to the list with its place; what depends on several keys is checked in plan.hpp.
#ifndef TALUS_SANDBOX_CONFIG_READ_HPP
#define TALUS_SANDBOX_CONFIG_READ_HPP

#include <string>
#include <vector>

#include "config.hpp"
#include "faults.hpp"

namespace talus::sandbox {

// A value from the command line: the option it came with, and table.key=value in TOML syntax.
struct Setting {
    std::string option;
    std::string text;
};

// `source` is the name of the file the text came from. Settings replace what the file says; the last one counts.
Config read_config(const std::string& text, const std::string& source, const std::vector<Setting>& settings, Faults& faults);

} // namespace talus::sandbox

#endif
