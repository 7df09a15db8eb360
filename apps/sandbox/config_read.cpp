#include "config_read.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "config_keys.hpp"

namespace talus::sandbox {

namespace {

std::string node_text(const toml::node& node) {
    std::ostringstream stream;
    if (node.is_table())
        stream << "{...}";
    else if (const auto number = node.as_floating_point())
        stream << fmt::format("{}", number->get()); // as few digits as tell it from others
    else
        node.visit([&](const auto& value) { stream << value; });
    std::string text = stream.str();
    constexpr std::size_t kMost = 60;
    return text.size() > kMost ? text.substr(0, kMost) + "..." : text;
}

const char* type_name(const toml::node& node) {
    switch (node.type()) {
    case toml::node_type::string:
        return "a text";
    case toml::node_type::integer:
        return "a whole number";
    case toml::node_type::floating_point:
        return "a number with a fraction";
    case toml::node_type::boolean:
        return "true or false";
    case toml::node_type::array:
        return "a list";
    case toml::node_type::table:
        return "a table";
    default:
        return "a date or time";
    }
}

// Metres are asked for; people think in mm and um.
std::string unit_hint(const Key& key, double value) {
    if (std::string_view(key.unit) != "m" || value <= key.range.hi) return "";
    for (const auto& [name, factor] : {std::pair{"mm", 1e-3}, {"um", 1e-6}})
        if (key.range.holds(value * factor)) return fmt::format("; if {:g} {} is meant, write {:g}", value, name, value * factor);
    return "";
}

class Reader {
public:
    Reader(Config& config, Faults& faults) : config_(config), faults_(faults) {}

    // `origin` names what the text came from; `has_lines` says whether line and column mean anything to the user.
    void read_tables(const toml::table& root, const std::string& origin, bool has_lines) {
        origin_ = origin;
        has_lines_ = has_lines;
        for (const Entry& table : in_order(root)) {
            if (!is_table(table.name))
                fault(*table.source, unknown_table(table.name, *table.node));
            else if (!table.node->is_table())
                fault(*table.source, fmt::format("{} = {}: {} is a table of keys; write [{}] on a line of its own", table.name,
                                                 node_text(*table.node), table.name, table.name));
            else
                for (const Entry& key : in_order(*table.node->as_table())) read_key(table.name, key.name, *key.source, *key.node);
        }
    }

private:
    Config& config_;
    Faults& faults_;
    std::string origin_;
    bool has_lines_ = true;

    struct Entry {
        std::string name;
        const toml::source_region* source; // of the name
        const toml::node* node;
    };

    // A table's entries as they stand in the file; toml++ sorts them by name.
    static std::vector<Entry> in_order(const toml::table& table) {
        std::vector<Entry> entries;
        for (const auto& [name, node] : table) entries.push_back({std::string(name.str()), &name.source(), &node});
        std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
            const toml::source_position& p = a.source->begin;
            const toml::source_position& q = b.source->begin;
            return p.line != q.line ? p.line < q.line : p.column < q.column;
        });
        return entries;
    }

    std::string place(const toml::source_region& source) const {
        return has_lines_ ? fmt::format("{}:{}:{}", origin_, source.begin.line, source.begin.column) : origin_;
    }

    void fault(const toml::source_region& source, const std::string& text) { faults_.add(place(source) + ": " + text); }

    static bool is_table(const std::string& name) {
        for (const Key& key : config_keys())
            if (name == key.table) return true;
        return false;
    }

    static std::string unknown_table(const std::string& name, const toml::node& node) {
        std::vector<std::string> tables;
        for (const Key& key : config_keys()) {
            if (!node.is_table() && name == key.name)
                return fmt::format("{} = {}: this key belongs below [{}]", name, node_text(node), key.table);
            if (tables.empty() || tables.back() != key.table) tables.push_back(key.table);
        }
        if (!node.is_table())
            return fmt::format("{} = {}: unknown key outside of any table; the tables are {}", name, node_text(node),
                               fmt::join(tables, ", "));
        const std::string near = nearest_name(name, tables);
        if (!near.empty()) return fmt::format("[{}]: unknown table; did you mean [{}]?", name, near);
        return fmt::format("[{}]: unknown table; there are {}", name, fmt::join(tables, ", "));
    }

    void read_key(const std::string& table, const std::string& name, const toml::source_region& source, const toml::node& node) {
        const std::string path = table + "." + name;
        const Key* key = find_key(path);
        if (key == nullptr) {
            fault(source, fmt::format("{} = {}: unknown key; {}", path, node_text(node), suggestion(table, name)));
            return;
        }
        config_.given[path] = {place(source), node_text(node)};
        config_.refused.erase(path);
        const std::size_t faults_before = faults_.count();
        std::visit([&](auto* slot) { store(*key, source, node, *slot); }, key->slot(config_));
        if (faults_.count() != faults_before) config_.refused.insert(path);
    }

    static std::string suggestion(const std::string& table, const std::string& name) {
        std::vector<std::string> here;
        std::vector<std::string> elsewhere;
        for (const Key& key : config_keys()) {
            if (table == key.table)
                here.push_back(key.name);
            else if (name == key.name)
                elsewhere.push_back(key.path());
        }
        const std::string near = nearest_name(name, here);
        if (!near.empty()) return fmt::format("did you mean {}.{}?", table, near);
        if (!elsewhere.empty()) return fmt::format("did you mean {}?", fmt::join(elsewhere, " or "));
        return fmt::format("[{}] has {}", table, fmt::join(here, ", "));
    }

    void wrong_type(const Key& key, const toml::source_region& source, const toml::node& node) {
        fault(source, fmt::format("{} = {}: is {}; give {}", key.path(), node_text(node), type_name(node), expectation(key)));
    }

    bool in_range(const Key& key, const toml::source_region& source, const toml::node& node, double value) {
        if (std::isfinite(value) && key.range.holds(value)) return true;
        const char* problem = std::isfinite(value) ? "is out of range" : "is not a finite number";
        fault(source, fmt::format("{} = {}: {}; give {}{}", key.path(), node_text(node), problem, expectation(key), unit_hint(key, value)));
        return false;
    }

    void store(const Key& key, const toml::source_region& source, const toml::node& node, double& slot) {
        if (!node.is_number())
            wrong_type(key, source, node);
        else if (const double value = *node.value<double>(); in_range(key, source, node, value))
            slot = value;
    }
    void store(const Key& key, const toml::source_region& source, const toml::node& node, std::int64_t& slot) {
        if (!node.is_integer())
            wrong_type(key, source, node);
        else if (const std::int64_t value = *node.value<std::int64_t>(); in_range(key, source, node, static_cast<double>(value)))
            slot = value;
    }
    template <class T>
    void store(const Key& key, const toml::source_region& source, const toml::node& node, std::optional<T>& slot) {
        T value{};
        const std::size_t faults_before = faults_.count();
        store(key, source, node, value);
        if (faults_.count() == faults_before) slot = value;
    }
    void store(const Key& key, const toml::source_region& source, const toml::node& node, bool& slot) {
        if (!node.is_boolean())
            wrong_type(key, source, node);
        else
            slot = *node.value<bool>();
    }
    void store(const Key& key, const toml::source_region& source, const toml::node& node, std::string& slot) {
        if (!node.is_string())
            wrong_type(key, source, node);
        else
            slot = *node.value<std::string>();
    }
    void store(const Key& key, const toml::source_region& source, const toml::node& node, std::int32_t& slot) {
        if (!node.is_string()) return wrong_type(key, source, node);
        const std::string name = *node.value<std::string>();
        std::vector<std::string> names;
        for (const Word& word : key.words) {
            if (name == word.name) {
                slot = word.value;
                return;
            }
            names.push_back(word.name);
        }
        const std::string near = nearest_name(name, names);
        fault(source, fmt::format("{} = {}: unknown; {}{}", key.path(), node_text(node),
                                  near.empty() ? "" : fmt::format("did you mean \"{}\"? It is ", near), expectation(key)));
    }
    void store(const Key& key, const toml::source_region& source, const toml::node& node, std::array<std::int64_t, 3>& slot) {
        const toml::array* list = node.as_array();
        if (list == nullptr || list->size() != 3) return wrong_type(key, source, node);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto value = (*list)[axis].is_integer() ? (*list)[axis].value<std::int64_t>() : std::nullopt;
            if (!value || !key.range.holds(static_cast<double>(*value))) return wrong_type(key, source, node);
            slot[axis] = *value;
        }
    }
    void store(const Key& key, const toml::source_region& source, const toml::node& node, Config::Shorten::Moving& slot) {
        const toml::array* list = node.as_array();
        if (list == nullptr) return wrong_type(key, source, node);
        slot = {false, false, false};
        for (const toml::node& item : *list) {
            const std::string name = item.is_string() ? *item.value<std::string>() : "";
            if (name == "floor")
                slot.floor = true;
            else if (name == "front")
                slot.front = true;
            else if (name == "sides")
                slot.sides = true;
            else
                fault(source, fmt::format("{} = {}: {} is not a wall that can move; give {}", key.path(), node_text(node), node_text(item),
                                          expectation(key)));
        }
    }
};

void read_setting(const Setting& setting, Reader& reader, Faults& faults) {
    const std::string& text = setting.text;
    const std::size_t equals = text.find('=');
    const std::size_t dot = text.find('.');
    if (equals == std::string::npos || dot == std::string::npos || dot > equals) {
        faults.add(fmt::format("{} {}: is not of the form table.key=value", setting.option, text));
        return;
    }
    try {
        reader.read_tables(toml::parse(text), setting.option, false);
    } catch (const toml::parse_error& error) {
        faults.add(fmt::format("{} {}: {}; values are written as in TOML: numbers, true and false as they are, "
                               "texts in quotes, as in {} '{}=\"{}\"'",
                               setting.option, text, error.description(), setting.option, text.substr(0, equals), text.substr(equals + 1)));
    }
}

} // namespace

Config read_config(const std::string& text, const std::string& source, const std::vector<Setting>& settings, Faults& faults) {
    Config config;
    config.source = source;
    Reader reader(config, faults);
    try {
        reader.read_tables(toml::parse(text, source), source, true);
    } catch (const toml::parse_error& error) {
        const toml::source_position at = error.source().begin;
        faults.add(fmt::format("{}:{}:{}: {}", source, at.line, at.column, error.description()));
        return config; // nothing else can be said about a file that is not TOML
    }
    // A relative path means: relative to where it is written. The folder is not needed again after this.
    const std::filesystem::path folder = std::filesystem::path(source).parent_path();
    for (std::string* path : {&config.bed.file, &config.settle.bed_cache})
        if (!path->empty()) *path = (folder / *path).string();
    for (const Setting& setting : settings) read_setting(setting, reader, faults);
    return config;
}

} // namespace talus::sandbox
