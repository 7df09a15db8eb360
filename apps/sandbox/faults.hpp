// faults.hpp: what is wrong with an input, all of it. Checks add faults and go on; one throw reports the lot.
#ifndef TALUS_SANDBOX_FAULTS_HPP
#define TALUS_SANDBOX_FAULTS_HPP

#include <string>
#include <string_view>
#include <vector>

namespace talus::sandbox {

class Faults {
public:
    // One line: "where: subject: what is wrong; what would be right". Line breaks in `text` are flattened.
    void add(std::string text);
    bool empty() const { return total_ == 0; }
    std::size_t count() const { return total_; }
    // Throws a Failure(kExitInput) that lists every fault; `source` names the input in the first line.
    void throw_if_any(const std::string& source) const;

private:
    // A file in the wrong format has a fault in every line; the first ones tell it.
    static constexpr std::size_t kMostShown = 40;
    std::vector<std::string> lines_;
    std::size_t total_ = 0;
};

// The candidate nearest to `word` if it is near enough to be meant, else empty (edit distance, capitals ignored).
std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates);

} // namespace talus::sandbox

#endif
