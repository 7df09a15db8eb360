#include "progress.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace talus::sandbox {

namespace {

constexpr std::chrono::milliseconds kTerminalInterval{1000};
constexpr std::chrono::milliseconds kPlainInterval{10000};

double seconds(std::chrono::steady_clock::duration d) { return std::chrono::duration<double>(d).count(); }

// Is standard output seen by a person? Open MPI gives its ranks a pseudo-terminal even when its own output goes to a
// file; then the output of mpirun, the parent of rank 0, decides.
bool is_terminal() {
    if (isatty(STDOUT_FILENO) == 0) return false;
    if (std::getenv("OMPI_COMM_WORLD_SIZE") == nullptr) return true;
    std::error_code error;
    const std::string target = std::filesystem::read_symlink(fmt::format("/proc/{}/fd/1", getppid()), error).string();
    return target.rfind("/dev/pts/", 0) == 0 || target.rfind("/dev/tty", 0) == 0;
}

// A line longer than the terminal is wide could not be renewed. 0 if the width is not known.
std::size_t terminal_width() {
    winsize size = {};
    return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

} // namespace

std::string duration_text(double seconds) {
    if (seconds < 100) return fmt::format("{:.0f} s", seconds);
    const auto whole = static_cast<std::int64_t>(std::llround(seconds));
    if (whole < 6000) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
    if (whole < 360000) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
    constexpr double kDay = 86400, kYear = 365.25 * kDay;
    return seconds < kYear ? fmt::format("{:.1f} days", seconds / kDay) : fmt::format("{:.3g} years", seconds / kYear);
}

Progress::Progress(const Team& team)
    : team_(team), is_terminal_(is_terminal()), shown_time_(Clock::now()), interval_(is_terminal_ ? kTerminalInterval : kPlainInterval) {}

void Progress::clear_line() {
    if (has_line_) fmt::print("\r\x1b[K");
    has_line_ = false;
}

void Progress::say(const std::string& line) {
    if (!team_.is_root()) return;
    clear_line();
    fmt::print("{}\n", line);
    std::fflush(stdout);
}

void Progress::begin(const std::string& stage, std::int64_t grains, std::int64_t goal) {
    stage_ = stage;
    grains_ = grains;
    goal_ = goal;
    shown_step_ = 0;
    shown_time_ = Clock::now();
}

bool Progress::is_due() { return team_.from_root(std::int64_t{Clock::now() - shown_time_ >= interval_}) != 0; }

void Progress::show(std::int64_t step, const std::string& detail, double imbalance) {
    if (!team_.is_root()) return;
    const Clock::time_point now = Clock::now();
    const double rate = static_cast<double>(step - shown_step_) / seconds(now - shown_time_);
    shown_step_ = step;
    shown_time_ = now;
    std::string line = fmt::format("{:<9} {}", stage_, detail);
    if (goal_ > 0) line += fmt::format("  {:.1f} %", 100.0 * static_cast<double>(step) / static_cast<double>(goal_));
    line += fmt::format("  {:.0f} steps/s  {:.2f} M particle-steps/s", rate, 1e-6 * rate * static_cast<double>(grains_));
    if (imbalance > 0) line += fmt::format("  imbalance {:.2f}", imbalance);
    if (goal_ > 0 && rate > 0) line += "  ETA " + duration_text(static_cast<double>(goal_ - step) / rate);
    clear_line();
    if (const std::size_t width = terminal_width(); is_terminal_ && width > 0) line = line.substr(0, width - 1);
    if (is_terminal_)
        fmt::print("{}", line);
    else
        fmt::print("{}\n", line);
    has_line_ = is_terminal_;
    std::fflush(stdout);
}

void Progress::end(const std::string& summary) { say(fmt::format("{:<9} {}", stage_, summary)); }

} // namespace talus::sandbox
