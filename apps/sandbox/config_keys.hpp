// config_keys.hpp: the table of all configuration keys: name, unit, range, default, meaning. Reading, the list printed
// by `talus-sandbox keys`, the record of the configuration in summary.json and the name of a kept bed all use it.
#ifndef TALUS_SANDBOX_CONFIG_KEYS_HPP
#define TALUS_SANDBOX_CONFIG_KEYS_HPP

#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "config.hpp"

namespace talus::sandbox {

struct Word { // a value that is one of a few words
    const char* name;
    std::int32_t value;
};

// The member of a Config that a key sets. std::int32_t is one of the key's words.
using Slot = std::variant<double*, std::optional<double>*, std::int64_t*, std::optional<std::int64_t>*, bool*, std::int32_t*, std::string*,
                          std::array<std::int64_t, 3>*, Config::Shorten::Moving*>;

struct Range {
    double lo = -std::numeric_limits<double>::infinity();
    double hi = std::numeric_limits<double>::infinity();
    bool lo_open = false; // the lower end itself is refused
    bool hi_open = false;

    bool holds(double value) const { return (lo_open ? value > lo : value >= lo) && (hi_open ? value < hi : value <= hi); }
};

// Does the key change the bed that settling makes? Such keys name the kept bed.
enum class Effect { kAnything, kSettledBed };

struct Key {
    const char* table;
    const char* name;
    const char* unit; // "1" for pure numbers, empty for words and texts
    const char* meaning;
    Slot (*slot)(Config&);
    Range range;
    Effect effect = Effect::kAnything;
    std::vector<Word> words = {};
    const char* when_absent = ""; // what an optional key means when it is not given

    std::string path() const { return std::string(table) + "." + name; }
};

const std::vector<Key>& config_keys();
const Key* find_key(const std::string& path);

// The value a key has in `config`, in TOML syntax; empty if it is optional and absent.
std::string value_text(const Key& key, const Config& config);
// "a number above 0 and up to 10 m", "one of ...": what would be right, ending in the default.
std::string expectation(const Key& key);
// Where `path` was set, or the file if it was not; and "path = value", marked when it is the default.
std::string where(const Config& config, const std::string& path);
std::string subject(const Config& config, const std::string& path);
// All keys with unit, range, default and meaning, for `talus-sandbox keys`.
std::string key_list();

} // namespace talus::sandbox

#endif
