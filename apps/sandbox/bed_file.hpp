// bed_file.hpp: a settled bed read from a file, for [bed] file.
//   text   "# N xlo xhi ylo yhi zlo zhi", then N lines "id x y z r"; SI units
//   HDF5   datasets id [N], position [N x 3], radius [N]; attribute box, the same six numbers; or a snapshot of a run
// Which of the file's axes is up is told by [bed] axes: "xzy" makes x, z, y of the file our x, y (up), z.
#ifndef TALUS_SANDBOX_BED_FILE_HPP
#define TALUS_SANDBOX_BED_FILE_HPP

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "faults.hpp"
#include "team.hpp"

namespace talus::sandbox {

// What all ranks know of a bed.
struct BedSummary {
    std::int64_t count = 0;
    std::array<double, 3> lo{}; // the file's box after the change of axes
    std::array<double, 3> hi{};
    double radius_min = 0;
    double radius_max = 0;
    double top = 0;    // of the highest grain
    double volume = 0; // of all grains
};

struct Bed {
    std::array<double, 3> lo{};
    std::array<double, 3> hi{};
    std::vector<std::int64_t> label;
    std::vector<double> position; // 3 a grain
    std::vector<double> radius;
    std::vector<std::int32_t> group; // empty: all free; files have none

    BedSummary summary() const;
};

// Reads and checks a file; every fault is added with its line (text) or row (HDF5). [local]
Bed read_bed(const std::string& path, const std::string& axes, Faults& faults);

// The readers of the two formats; axes as in the file, nothing checked but the format itself.
struct RawBed {
    Bed bed;
    std::vector<std::int64_t> line; // of each grain in the text file; empty for HDF5
    std::int64_t stated_count = -1; // by the head line
    bool has_box = false;
};
RawBed read_bed_text(const std::string& path, Faults& faults);
RawBed read_bed_hdf5(const std::string& path, Faults& faults);

// Rank 0's summary on every rank. [collective]
BedSummary share(const Team& team, const BedSummary& summary);

} // namespace talus::sandbox

#endif
