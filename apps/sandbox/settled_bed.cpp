#include "settled_bed.hpp"

#include <fmt/format.h>

#include "config_keys.hpp"

namespace talus::sandbox {

namespace {

// FNV-1a, 64 bits: a name, not a guard; the checkpoint has a digest of its own.
std::uint64_t hash_of(const std::string& text) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    return hash;
}

} // namespace

std::string settled_bed_name(const Config& config, const Plan& plan) {
    // The number at the front is raised when settling itself is changed in this driver.
    std::string text = fmt::format("settled bed 1, library {}, domain {} {} {}\n", talus_version(), plan.hi[0], plan.hi[1], plan.hi[2]);
    for (const Key& key : config_keys())
        if (key.effect == Effect::kSettledBed && key.path() != "box.height")
            text += fmt::format("{} = {}\n", key.path(), value_text(key, config));
    return fmt::format("settled-{:016x}.ckpt", hash_of(text));
}

} // namespace talus::sandbox
