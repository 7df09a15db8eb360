#include "bed_file.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <unordered_map>

#include <fmt/format.h>

namespace talus::sandbox {

namespace {

constexpr char kAxisName[] = "xyz";
constexpr std::int64_t kLabelEnd = std::int64_t{1} << 62; // talus.h

// HDF5 files begin with these eight bytes.
bool is_hdf5(const std::string& path) {
    constexpr char kSignature[] = {'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
    char head[sizeof kSignature] = {};
    std::ifstream stream(path, std::ios::binary);
    stream.read(head, sizeof head);
    return stream && std::equal(std::begin(head), std::end(head), std::begin(kSignature));
}

class Checker {
public:
    Checker(const std::string& path, const RawBed& raw, Faults& faults) : path_(path), raw_(raw), faults_(faults) {}

    void check() {
        const Bed& bed = raw_.bed;
        if (raw_.has_box)
            for (int axis = 0; axis < 3; ++axis)
                if (!(bed.lo[axis] < bed.hi[axis]) || !std::isfinite(bed.lo[axis]) || !std::isfinite(bed.hi[axis]))
                    faults_.add(fmt::format("{}: box: {}lo = {} and {}hi = {}; the upper end must be above the lower", path_,
                                            kAxisName[axis], bed.lo[axis], kAxisName[axis], bed.hi[axis]));
        std::unordered_map<std::int64_t, std::size_t> seen;
        seen.reserve(bed.label.size());
        for (std::size_t grain = 0; grain < bed.label.size(); ++grain) {
            check_grain(grain);
            const auto [first, is_new] = seen.emplace(bed.label[grain], grain);
            if (!is_new)
                faults_.add(fmt::format("{}: id {} was given before, at {}; labels are unique", place(grain), bed.label[grain],
                                        place(first->second)));
        }
        if (bed.label.empty() && faults_.empty()) faults_.add(fmt::format("{}: holds no grains; a bed needs at least one", path_));
        if (raw_.stated_count >= 0 && faults_.empty() && raw_.stated_count != static_cast<std::int64_t>(bed.label.size()))
            faults_.add(fmt::format("{}: the head states {} grains, the file holds {}; it is cut short or the head is "
                                    "wrong",
                                    path_, raw_.stated_count, bed.label.size()));
    }

private:
    const std::string& path_;
    const RawBed& raw_;
    Faults& faults_;

    std::string place(std::size_t grain) const {
        return raw_.line.empty() ? fmt::format("{}: row {}", path_, grain) : fmt::format("{}:{}", path_, raw_.line[grain]);
    }

    void check_grain(std::size_t grain) {
        const Bed& bed = raw_.bed;
        const std::int64_t label = bed.label[grain];
        if (label < 0 || label >= kLabelEnd)
            faults_.add(fmt::format("{}: id {}; labels are whole numbers from 0 to below 2^62", place(grain), label));
        const double radius = bed.radius[grain];
        if (!std::isfinite(radius) || radius <= 0)
            faults_.add(fmt::format("{}: radius {} of grain {}; it must be a number above 0, in m", place(grain), radius, label));
        for (int axis = 0; axis < 3; ++axis) {
            const double x = bed.position[3 * grain + axis];
            if (!std::isfinite(x))
                faults_.add(
                    fmt::format("{}: {} = {} of grain {}; it must be a finite number, in m", place(grain), kAxisName[axis], x, label));
            else if (raw_.has_box && (x < bed.lo[axis] || x > bed.hi[axis]))
                faults_.add(fmt::format("{}: {} = {} of grain {} is outside the box, {} to {}", place(grain), kAxisName[axis], x, label,
                                        bed.lo[axis], bed.hi[axis]));
        }
    }
};

void permute(const std::string& axes, Bed& bed) {
    int from[3];
    for (int axis = 0; axis < 3; ++axis) from[axis] = axes[axis] - 'x';
    const auto turn = [&](auto* x) {
        const double old[3] = {x[0], x[1], x[2]};
        for (int axis = 0; axis < 3; ++axis) x[axis] = old[from[axis]];
    };
    turn(bed.lo.data());
    turn(bed.hi.data());
    for (std::size_t grain = 0; grain < bed.label.size(); ++grain) turn(&bed.position[3 * grain]);
}

} // namespace

Bed read_bed(const std::string& path, const std::string& axes, Faults& faults) {
    if (!std::ifstream(path)) {
        faults.add(fmt::format("{}: cannot be opened; give the path of a bed file that can be read", path));
        return {};
    }
    const std::size_t faults_before = faults.count();
    RawBed raw = is_hdf5(path) ? read_bed_hdf5(path, faults) : read_bed_text(path, faults);
    if (faults.count() == faults_before || !raw.bed.label.empty()) Checker(path, raw, faults).check();
    if (faults.count() == faults_before) permute(axes, raw.bed);
    return std::move(raw.bed);
}

BedSummary Bed::summary() const {
    BedSummary sum;
    sum.count = static_cast<std::int64_t>(label.size());
    sum.lo = lo;
    sum.hi = hi;
    if (label.empty()) return sum;
    const auto [least, largest] = std::minmax_element(radius.begin(), radius.end());
    sum.radius_min = *least;
    sum.radius_max = *largest;
    sum.top = lo[1];
    for (std::size_t grain = 0; grain < label.size(); ++grain) {
        const double r = radius[grain];
        sum.top = std::max(sum.top, position[3 * grain + 1] + r);
        sum.volume += 4 * std::numbers::pi / 3 * r * r * r;
    }
    return sum;
}

BedSummary share(const Team& team, const BedSummary& summary) {
    BedSummary shared;
    shared.count = team.from_root(summary.count);
    for (int axis = 0; axis < 3; ++axis) {
        shared.lo[axis] = team.from_root(summary.lo[axis]);
        shared.hi[axis] = team.from_root(summary.hi[axis]);
    }
    shared.radius_min = team.from_root(summary.radius_min);
    shared.radius_max = team.from_root(summary.radius_max);
    shared.top = team.from_root(summary.top);
    shared.volume = team.from_root(summary.volume);
    return shared;
}

} // namespace talus::sandbox
