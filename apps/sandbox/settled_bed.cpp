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

// The keys that a settled bed depends on, but for some, with their values.
std::string bed_keys(const Config& config, const std::set<std::string>& without) {
    std::string text;
    for (const Key& key : config_keys())
        if (key.effect == Effect::kSettledBed && without.count(key.path()) == 0)
            text += fmt::format("{} = {}\n", key.path(), value_text(key, config));
    return text;
}

} // namespace

std::string settled_bed_name(const Config& config, const Plan& plan) {
    // The number at the front is raised when settling itself is changed in this driver.
    const std::string head = fmt::format("settled bed 1, library {}, domain {} {} {}\n", talus_version(), plan.hi[0], plan.hi[1], plan.hi[2]);
    return fmt::format("settled-{:016x}.ckpt", hash_of(head + bed_keys(config, {"box.height"})));
}

std::string settling_key(const Config& config) {
    return fmt::format("{:016x}", hash_of(bed_keys(config, {"box.height", "box.length", "box.width", "box.periodic_z", "run.seed",
                                                            "settle.cap", "engine.energy_ledger"})));
}

} // namespace talus::sandbox
