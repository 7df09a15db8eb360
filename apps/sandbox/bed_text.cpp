// bed_text.cpp: the text format of bed files.
#include <charconv>
#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "bed_file.hpp"

namespace talus::sandbox {

namespace {

std::vector<std::string_view> split(std::string_view line) {
    constexpr std::string_view kBlank = " \t\r,";
    std::vector<std::string_view> words;
    for (std::size_t begin = line.find_first_not_of(kBlank); begin != std::string_view::npos;) {
        const std::size_t end = std::min(line.find_first_of(kBlank, begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        begin = line.find_first_not_of(kBlank, end);
    }
    return words;
}

// The whole word, and only it, is the number; "nan" and "inf" are numbers here and refused later, by name.
template <class T>
bool parse(std::string_view word, T& value) {
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size();
}

void read_head(const std::string& place, const std::vector<std::string_view>& words, RawBed& raw, Faults& faults) {
    double numbers[6];
    bool good = words.size() == 7 && parse(words[0], raw.stated_count) && raw.stated_count >= 0;
    for (std::size_t i = 0; good && i < 6; ++i) good = parse(words[i + 1], numbers[i]);
    if (!good) {
        raw.stated_count = -1;
        faults.add(fmt::format("{}: the first line must be \"# N xlo xhi ylo yhi zlo zhi\", in m", place));
        return;
    }
    for (int axis = 0; axis < 3; ++axis) {
        raw.bed.lo[axis] = numbers[2 * axis];
        raw.bed.hi[axis] = numbers[2 * axis + 1];
    }
    raw.has_box = true;
}

} // namespace

RawBed read_bed_text(const std::string& path, Faults& faults) {
    RawBed raw;
    std::ifstream stream(path);
    std::string line;
    for (std::int64_t number = 1; std::getline(stream, line); ++number) {
        const std::string place = fmt::format("{}:{}", path, number);
        std::vector<std::string_view> words = split(line);
        const bool is_comment = !words.empty() && words[0].front() == '#';
        if (number == 1) {
            if (is_comment && words[0].size() > 1)
                words[0].remove_prefix(1);
            else if (is_comment)
                words.erase(words.begin());
            read_head(place, is_comment ? words : std::vector<std::string_view>{}, raw, faults);
            if (is_comment) continue;
        }
        if (words.empty() || is_comment) continue;
        if (words.size() != 5) {
            faults.add(fmt::format("{}: {} columns; a grain is \"id x y z r\"", place, words.size()));
            continue;
        }
        std::int64_t label = 0;
        double x[4];
        bool good = parse(words[0], label);
        if (!good) faults.add(fmt::format("{}: id \"{}\" is not a whole number", place, words[0]));
        for (std::size_t i = 0; i < 4; ++i)
            if (!parse(words[i + 1], x[i])) {
                faults.add(fmt::format("{}: {} = \"{}\" is not a number", place, "xyzr"[i], words[i + 1]));
                good = false;
            }
        if (!good) continue;
        raw.bed.label.push_back(label);
        raw.bed.position.insert(raw.bed.position.end(), x, x + 3);
        raw.bed.radius.push_back(x[3]);
        raw.line.push_back(number);
    }
    if (!raw.has_box && raw.bed.label.empty() && faults.empty())
        faults.add(fmt::format("{}: is empty; the first line must be \"# N xlo xhi ylo yhi zlo zhi\"", path));
    return raw;
}

} // namespace talus::sandbox
