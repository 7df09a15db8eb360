#include "faults.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>

#include <fmt/format.h>

#include "failure.hpp"

namespace talus::sandbox {

void Faults::add(std::string text) {
    ++total_;
    if (lines_.size() == kMostShown) return;
    std::replace(text.begin(), text.end(), '\n', ' ');
    lines_.push_back(std::move(text));
}

void Faults::throw_if_any(const std::string& source) const {
    if (empty()) return;
    std::string text = fmt::format("{} {} in {}", total_, total_ == 1 ? "fault" : "faults", source);
    for (const std::string& line : lines_) text += "\n" + line;
    if (total_ > lines_.size()) text += fmt::format("\n... and {} more", total_ - lines_.size());
    throw Failure(kExitInput, text);
}

namespace {

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// Levenshtein distance with one row.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t above = row[j];
            const std::size_t change = diagonal + (lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1);
            row[j] = std::min({above + 1, row[j - 1] + 1, change});
            diagonal = above;
        }
    }
    return row[b.size()];
}

} // namespace

std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates) {
    std::string best;
    std::size_t best_distance = (word.size() < 4 ? 1 : std::max<std::size_t>(2, word.size() / 3)) + 1;
    for (const std::string& candidate : candidates) {
        const std::size_t distance = edit_distance(word, candidate);
        if (distance < best_distance && distance < std::max(word.size(), candidate.size())) {
            best_distance = distance;
            best = candidate;
        }
    }
    return best;
}

} // namespace talus::sandbox
