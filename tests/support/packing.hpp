// packing.hpp: what a packing looks like, computed from positions and radii alone: contacts, rattlers, solid fraction.
#pragma once

#include "engine.hpp"
#include "theory.hpp"

#include <cmath>
#include <cstddef>
#include <vector>

namespace talus::test {

/// Spheres over a floor at y = 0, periodic in x and z.
class Packing {
public:
    Packing(std::vector<Vec3> positions, std::vector<double> radii, double width_x, double width_z)
        : positions_(std::move(positions)),
          radii_(std::move(radii)),
          width_x_(width_x),
          width_z_(width_z),
          contacts_(positions_.size()),
          rattler_(positions_.size(), 0) {
        find_contacts();
        find_rattlers();
    }

    struct Slice {
        double solid_fraction = 0.0;    // exact: caps cut by the faces count for what is inside
        double contacts = 0.0;          // mean over grains with centre inside, rattlers too
        double contacts_of_frame = 0.0; // without rattlers, whose contacts do not count either
        std::size_t grains = 0;
        std::size_t rattlers = 0;
    };
    Slice slice(double from, double to) const {
        Slice s;
        double volume = 0.0;
        double all = 0.0;
        double frame = 0.0;
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            volume += volume_below(i, to) - volume_below(i, from);
            if (positions_[i][1] < from || positions_[i][1] >= to) continue;
            ++s.grains;
            all += static_cast<double>(contacts_[i].size()) + (on_floor(i) ? 1.0 : 0.0);
            if (rattler_[i]) {
                ++s.rattlers;
                continue;
            }
            for (const std::size_t j : contacts_[i]) frame += rattler_[j] ? 0.0 : 1.0;
            frame += on_floor(i) ? 1.0 : 0.0;
        }
        s.solid_fraction = volume / (width_x_ * width_z_ * (to - from));
        s.contacts = all / static_cast<double>(s.grains);
        s.contacts_of_frame = frame / static_cast<double>(s.grains - s.rattlers);
        return s;
    }
    /// Height of a uniform bed with the same centre of mass: the mean surface.
    double surface() const {
        double volume = 0.0;
        double moment = 0.0;
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            const double v = radii_[i] * radii_[i] * radii_[i];
            volume += v;
            moment += v * positions_[i][1];
        }
        return 2.0 * moment / volume;
    }

private:
    bool on_floor(std::size_t i) const { return positions_[i][1] < radii_[i]; }

    double volume_below(std::size_t i, double level) const {
        const double r = radii_[i];
        const double t = std::fmin(r, std::fmax(-r, level - positions_[i][1]));
        return kPi * (r * r * t - t * t * t / 3.0 + 2.0 * r * r * r / 3.0);
    }

    void find_contacts() {
        double largest = 0.0;
        double top = 0.0;
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            largest = std::fmax(largest, radii_[i]);
            top = std::fmax(top, positions_[i][1]);
        }
        const double size = 2.0 * largest;
        const auto count = [size](double width) { return static_cast<long>(std::fmax(3.0, std::floor(width / size))); };
        const long nx = count(width_x_), ny = count(top + size), nz = count(width_z_);
        const auto cell_of = [](double x, double width, long n) {
            const long c = static_cast<long>(std::floor(x / width * static_cast<double>(n)));
            return c < 0 ? 0 : (c >= n ? n - 1 : c);
        };
        std::vector<std::vector<std::size_t>> cells(static_cast<std::size_t>(nx * ny * nz));
        const auto at = [&](long x, long y, long z) -> std::vector<std::size_t>& {
            return cells[static_cast<std::size_t>((((x + nx) % nx) * ny + y) * nz + (z + nz) % nz)];
        };
        const auto home = [&](std::size_t i) {
            return std::array<long, 3>{cell_of(positions_[i][0], width_x_, nx), cell_of(positions_[i][1], top + size, ny),
                                       cell_of(positions_[i][2], width_z_, nz)};
        };
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            const auto [x, y, z] = home(i);
            at(x, y, z).push_back(i);
        }
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            const auto [x, y, z] = home(i);
            for (long dx = -1; dx <= 1; ++dx)
                for (long dy = -1; dy <= 1; ++dy)
                    for (long dz = -1; dz <= 1; ++dz) {
                        if (y + dy < 0 || y + dy >= ny) continue;
                        for (const std::size_t j : at(x + dx, y + dy, z + dz))
                            if (j > i && touch(i, j)) {
                                contacts_[i].push_back(j);
                                contacts_[j].push_back(i);
                            }
                    }
        }
    }
    bool touch(std::size_t i, std::size_t j) const {
        Vec3 d = positions_[i] - positions_[j];
        d[0] -= width_x_ * std::round(d[0] / width_x_);
        d[2] -= width_z_ * std::round(d[2] / width_z_);
        const double reach = radii_[i] + radii_[j];
        return dot(d, d) < reach * reach;
    }

    /// A grain with fewer than four contacts to grains that are no rattlers cannot be held by forces that push.
    void find_rattlers() {
        for (bool changed = true; changed;) {
            changed = false;
            for (std::size_t i = 0; i < positions_.size(); ++i) {
                if (rattler_[i]) continue;
                int held = on_floor(i) ? 1 : 0;
                for (const std::size_t j : contacts_[i]) held += rattler_[j] ? 0 : 1;
                if (held < 4) rattler_[i] = changed = true;
            }
        }
    }

    std::vector<Vec3> positions_;
    std::vector<double> radii_;
    double width_x_, width_z_;
    std::vector<std::vector<std::size_t>> contacts_;
    std::vector<char> rattler_;
};

} // namespace talus::test
