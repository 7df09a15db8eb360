// config_text.cpp: how keys and values are worded in messages and lists.
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "config_keys.hpp"

namespace talus::sandbox {

namespace {

template <class... F>
struct Overloaded : F... {
    using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

// A bound or a default, short: 0.0001, 1e-06, 4096.
std::string number(double value) { return fmt::format("{:g}", value); }

std::string range_text(const Range& range) {
    const bool has_lo = std::isfinite(range.lo);
    const bool has_hi = std::isfinite(range.hi);
    const std::string lo = number(range.lo);
    const std::string hi = number(range.hi);
    if (has_lo && has_hi && !range.lo_open) return fmt::format(" from {} to {}{}", lo, range.hi_open ? "below " : "", hi);
    if (has_lo && has_hi) return fmt::format(" above {} and {} {}", lo, range.hi_open ? "below" : "up to", hi);
    return !has_lo ? "" : range.lo_open ? " above " + lo : fmt::format(" of {} or more", lo);
}

std::string unit_text(const Key& key) { return *key.unit == '\0' || std::string_view(key.unit) == "1" ? "" : std::string(" ") + key.unit; }

std::string words_text(const Key& key) {
    std::vector<std::string> names;
    for (const Word& word : key.words) names.push_back(fmt::format("\"{}\"", word.name));
    return fmt::format("one of {}", fmt::join(names, ", "));
}

std::string kind_text(const Key& key) {
    Config config;
    const std::string span = range_text(key.range) + unit_text(key);
    return std::visit(Overloaded{
                          [&](double*) { return "a number" + span; },
                          [&](std::optional<double>*) { return "a number" + span; },
                          [&](std::int64_t*) { return "a whole number" + span; },
                          [&](std::optional<std::int64_t>*) { return "a whole number" + span; },
                          [&](bool*) { return std::string("true or false"); },
                          [&](std::int32_t*) { return words_text(key); },
                          [&](std::string*) { return std::string("a text in quotes"); },
                          [&](std::array<std::int64_t, 3>*) { return std::string("three whole numbers of 0 or more, as in [2, 1, 2]"); },
                          [&](Config::Shorten::Moving*) { return std::string("a list of \"floor\", \"front\" and \"sides\""); },
                      },
                      key.slot(config));
}

std::string default_text(const Key& key) {
    const std::string value = value_text(key, Config());
    return value.empty() || value == "\"\"" ? key.when_absent : value;
}

} // namespace

std::string value_text(const Key& key, const Config& config) {
    // Slots point into a Config; this one is only read through them.
    const Slot slot = key.slot(const_cast<Config&>(config));
    return std::visit(Overloaded{
                          [](const double* v) { return fmt::format("{}", *v); },
                          [](const std::optional<double>* v) { return v->has_value() ? fmt::format("{}", **v) : std::string(); },
                          [](const std::int64_t* v) { return fmt::format("{}", *v); },
                          [](const std::optional<std::int64_t>* v) { return v->has_value() ? fmt::format("{}", **v) : std::string(); },
                          [](const bool* v) { return std::string(*v ? "true" : "false"); },
                          [&](const std::int32_t* v) {
                              for (const Word& word : key.words)
                                  if (word.value == *v) return fmt::format("\"{}\"", word.name);
                              return std::string();
                          },
                          [](const std::string* v) { return fmt::format("\"{}\"", *v); },
                          [](const std::array<std::int64_t, 3>* v) { return fmt::format("{}", *v); },
                          [](const Config::Shorten::Moving* v) {
                              std::vector<std::string> names;
                              for (const auto& [moves, name] : {std::pair{v->floor, "floor"}, {v->front, "front"}, {v->sides, "sides"}})
                                  if (moves) names.push_back(fmt::format("\"{}\"", name));
                              return fmt::format("[{}]", fmt::join(names, ", "));
                          },
                      },
                      slot);
}

std::string expectation(const Key& key) {
    const std::string fallback = default_text(key);
    return kind_text(key) + (fallback.empty() ? "" : fmt::format(" (default: {})", fallback));
}

std::string where(const Config& config, const std::string& path) {
    const auto found = config.given.find(path);
    return found == config.given.end() ? config.source : found->second.where;
}

std::string subject(const Config& config, const std::string& path) {
    const auto found = config.given.find(path);
    if (found != config.given.end()) return fmt::format("{} = {}", path, found->second.value);
    const Key* key = find_key(path);
    const std::string value = key ? value_text(*key, config) : "";
    return value.empty() ? fmt::format("{} (not given)", path) : fmt::format("{} = {} (default)", path, value);
}

std::string key_list() {
    std::string text;
    std::string table;
    for (const Key& key : config_keys()) {
        if (table != key.table) {
            table = key.table;
            text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", table);
        }
        text += fmt::format("  {:<20} {}\n  {:<20} {}\n", key.name, key.meaning, "", expectation(key));
    }
    return text;
}

} // namespace talus::sandbox
