// progress.hpp: what a run says while it works. On a terminal one line is renewed; elsewhere a plain line is added now
// and then. Rank 0 alone speaks.
#ifndef TALUS_SANDBOX_PROGRESS_HPP
#define TALUS_SANDBOX_PROGRESS_HPP

#include <chrono>
#include <cstdint>
#include <string>

#include "team.hpp"

namespace talus::sandbox {

class Progress {
public:
    explicit Progress(const Team& team);

    // A line of its own. [rank 0 prints, no communication]
    void say(const std::string& line);

    // `goal` steps are expected; 0 if nobody knows.
    void begin(const std::string& stage, std::int64_t grains, std::int64_t goal);
    // Is it time for a new line? The same answer on every rank; rank 0's clock decides. [collective]
    bool is_due();
    // `detail` says where the stage is; imbalance 0 if not measured.
    void show(std::int64_t step, const std::string& detail, double imbalance);
    // Leaves the line of the stage as it is last, with `summary`.
    void end(const std::string& summary);

private:
    using Clock = std::chrono::steady_clock;
    const Team& team_;
    bool is_terminal_ = false;
    bool has_line_ = false; // a line without its end is on the terminal
    std::string stage_;
    std::int64_t grains_ = 0;
    std::int64_t goal_ = 0;
    std::int64_t shown_step_ = 0;
    Clock::time_point shown_time_;
    Clock::duration interval_;

    void clear_line();
};

// 42 s, 3 min 10 s, 2 h 05 min, 12.3 days, 4.5 years
std::string duration_text(double seconds);

} // namespace talus::sandbox

#endif
