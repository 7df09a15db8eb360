// apps/bench/grains.hpp: grains in plain columns, on their way into an engine, out of one, or to a file.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "talus.h"

namespace talus::bench {

struct Grains {
    std::vector<std::int64_t> label;
    std::vector<double> position, radius, velocity, spin; // as in talus_particles
    std::vector<std::int32_t> group;

    std::size_t count() const { return label.size(); }
    void add(std::int64_t of_label, const std::array<double, 3>& at, double of_radius, const std::array<double, 3>& moving, std::int32_t of_group);
};

/// Uniform numbers from the one generator whose bits the standard fixes: initial states are the same with every library.
class Random {
public:
    double uniform(double lo, double hi) { return lo + (hi - lo) * static_cast<double>(engine_() >> 11) * 0x1p-53; }

private:
    std::mt19937_64 engine_;
};

/// Mean over the grains that are not of a frozen group [m/s].
std::array<double, 3> mean_velocity(const Grains& grains);

void insert(talus_engine* engine, const Grains& grains, double max_overlap);
/// All grains of a serial engine, by label.
Grains gather(talus_engine* engine);

/// Write the text format of bed files (apps/sandbox/bed_file.hpp), with three more columns "vx vy vz" [m/s].
/// @param axes  which axes of the file are our x, y, z, as for reading
void write_bed(const std::string& path, const std::string& axes, const std::array<double, 3>& lo, const std::array<double, 3>& hi, const Grains& grains);

} // namespace talus::bench
