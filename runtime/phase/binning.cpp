// binning: owned grains in tile-major order.
#include <array>
#include <cmath>
#include <cstring>

#include "runtime/large_array.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::Particle;

namespace {

constexpr int kBlock = 4096; // grains a task

int n_blocks(std::size_t n) { return static_cast<int>((n + kBlock - 1) / kBlock); }

template <class Body>
void for_blocks(EngineState& s, std::size_t n, Body body) {
    s.workers.for_each(Phase::binning, n_blocks(n), [&](int b) {
        const std::size_t first = static_cast<std::size_t>(b) * kBlock;
        for (std::size_t i = first; i < std::min(n, first + kBlock); ++i) body(static_cast<std::uint32_t>(i));
    });
}

using Slice = core::ForceSum;

/// A slice for each of n grains, in the sums of the old tiles, which nobody asks for any more, as far as they go.
class SliceScratch {
public:
    SliceScratch(std::vector<core::Tile>& old_tiles, std::size_t n) : more_(find_blocks(old_tiles, (n + kSlices - 1) / kSlices) * kSlices * sizeof(Slice)) {
        for (std::size_t k = 0; blocks_.size() * kSlices < n; ++k) blocks_.push_back(more_.as<Slice>() + k * kSlices);
    }
    Slice& operator[](std::uint32_t i) const { return blocks_[i / kSlices][i % kSlices]; }

private:
    static constexpr std::uint32_t kSlices = 256; // of a block

    /// @return how many of so many blocks are still missing
    std::size_t find_blocks(std::vector<core::Tile>& old_tiles, std::size_t n) {
        for (core::Tile& tile : old_tiles)
            for (std::size_t k = 0; k + kSlices <= tile.sums.size() && blocks_.size() < n; k += kSlices) blocks_.push_back(&tile.sums[k]);
        return n - blocks_.size();
    }

    std::vector<Slice*> blocks_;
    Pages more_;
};

/// Bring items into an order, 64 bytes of each at a time: a second copy of all would be the most memory that a rank ever needs.
template <class T>
void permute(EngineState& s, std::vector<T>& items, const std::vector<std::uint32_t>& order, const SliceScratch& slices) {
    constexpr std::size_t kSlice = std::min(sizeof(T), sizeof(Slice));
    static_assert(sizeof(T) % kSlice == 0);
    for (std::size_t at = 0; at < sizeof(T); at += kSlice) {
        const auto slice = [&](std::uint32_t i) { return reinterpret_cast<std::byte*>(&items[i]) + at; };
        for_blocks(s, order.size(), [&](std::uint32_t i) { std::memcpy(&slices[i], slice(order[i]), kSlice); });
        for_blocks(s, order.size(), [&](std::uint32_t i) { std::memcpy(slice(i), &slices[i], kSlice); });
    }
}

void check_inside(const EngineState& s, const Particle& p) {
    const core::Domain& d = s.model.settings.domain;
    for (int a = 0; a < 3; ++a) {
        const double x = p.position[a];
        if (!std::isfinite(x) || !std::isfinite(p.velocity[a]) || !std::isfinite(p.angular_velocity[a]))
            core::fail(core::ErrorKind::unstable, "step {}: grain {} is not finite: position {} {} {}, velocity {} {} {} (rank {}); a smaller time step usually cures it", s.model.step, p.label, p.position[0],
                       p.position[1], p.position[2], p.velocity[0], p.velocity[1], p.velocity[2], s.comm->rank());
        if (!d.periodic[a] && (x < d.lo[a] || x > d.hi[a]))
            core::fail(core::ErrorKind::lost, "step {}: grain {} left the domain on axis {}: position {} {} {}, velocity {} {} {}, last owner rank {}; the domain there is {} to {}. Close it with a wall or make it larger",
                       s.model.step, p.label, "xyz"[a], p.position[0], p.position[1], p.position[2], p.velocity[0], p.velocity[1], p.velocity[2], s.comm->rank(), d.lo[a], d.hi[a]);
    }
}

/// The box of the owned grains, which all are where grains may be.
core::Box check_grains(EngineState& s) {
    const Subdomain& sub = s.sub;
    const core::Domain& d = s.model.settings.domain;
    core::Box empty{};
    if (sub.n_owned == 0) return {{d.lo[0], d.lo[1], d.lo[2]}, {d.lo[0], d.lo[1], d.lo[2]}};
    for (int a = 0; a < 3; ++a) {
        empty.lo[a] = HUGE_VAL;
        empty.hi[a] = -HUGE_VAL;
    }
    struct Part {
        core::Box box;
        bool sound = true;
    };
    std::vector<Part> parts(static_cast<std::size_t>(n_blocks(sub.n_owned)), Part{empty});
    for_blocks(s, sub.n_owned, [&](std::uint32_t i) {
        Part& part = parts[i / kBlock];
        const Particle& p = sub.particles[i];
        for (int a = 0; a < 3; ++a) {
            const double x = p.position[a];
            part.sound = part.sound && std::isfinite(x + p.velocity[a] + p.angular_velocity[a]) && (d.periodic[a] || (x >= d.lo[a] && x <= d.hi[a]));
            part.box.lo[a] = std::min(part.box.lo[a], x);
            part.box.hi[a] = std::max(part.box.hi[a], x);
        }
    });
    core::Box box = empty;
    for (const Part& part : parts) {
        if (!part.sound) // the first in order is told of
            for (core::LocalIndex i = 0; i < sub.n_owned; ++i) check_inside(s, sub.particles[i]);
        for (int a = 0; a < 3; ++a) {
            box.lo[a] = std::min(box.lo[a], part.box.lo[a]);
            box.hi[a] = std::max(box.hi[a], part.box.hi[a]);
        }
    }
    return box;
}

core::CellGrid grid_for(const EngineState& s, core::Box box) {
    const core::Domain& d = s.model.settings.domain;
    const double reach = s.model.reach();
    bool wraps[3];
    const core::Box mine = s.slices.box(s.comm->rank());
    for (int a = 0; a < 3; ++a) {
        wraps[a] = d.periodic[a] && s.slices.grid()[a] == 1;
        // Room for ghosts where the subdomain is cut.
        if (std::isfinite(mine.lo[a]) || (d.periodic[a] && !wraps[a])) box.lo[a] -= reach;
        if (std::isfinite(mine.hi[a]) || (d.periodic[a] && !wraps[a])) box.hi[a] += reach;
    }
    const int aim = s.model.settings.tile_grains > 0 ? s.model.settings.tile_grains : kDefaultTileGrains;
    return core::choose_grid(d, box.lo, box.hi, reach, wraps, s.sub.n_owned, static_cast<std::size_t>(aim));
}

} // namespace

void bin_grains(EngineState& s) {
    Subdomain& sub = s.sub;
    const core::Box extent = check_grains(s);
    sub.order = core::CellOrder(grid_for(s, extent));

    std::vector<std::uint32_t> cell(sub.n_owned), order;
    for_blocks(s, sub.n_owned, [&](std::uint32_t i) { cell[i] = sub.order.rank_of(sub.particles[i].position); });
    s.workers.timed(Phase::binning, 0, [&] {
        core::sort_by_cell(std::span<const std::uint32_t>(cell), sub.order.grid.n_cells(), [&](std::uint32_t i) { return sub.particles[i].label; }, sub.cell_first, order);
    });
    const SliceScratch slices(sub.old_tiles, order.size());
    permute(s, sub.particles, order, slices);
    permute(s, sub.references, order, slices);
    if (sub.keeps_sums) permute(s, sub.sums, order, slices);
    permute(s, sub.slot_of, order, slices);

    const core::CellGrid& grid = sub.order.grid;
    sub.tiles.clear();
    sub.tiles.resize(static_cast<std::size_t>(grid.n_tiles()));
    for (std::size_t k = 0; k < std::min(sub.tiles.size(), sub.old_tiles.size()); ++k) sub.tiles[k].sums.swap(sub.old_tiles[k].sums);
    int t = 0;
    for (int x = 0; x < grid.tiles[0]; ++x)
        for (int y = 0; y < grid.tiles[1]; ++y)
            for (int z = 0; z < grid.tiles[2]; ++z, ++t) {
                const std::uint32_t first = sub.cell_first[sub.order.first_of_tile[t]];
                core::Tile& tile = sub.tiles[t];
                std::copy_n(std::array{x, y, z}.data(), 3, tile.index);
                tile.first = first;
                tile.count = sub.cell_first[sub.order.first_of_tile[t + 1]] - first;
            }
    core::link_neighbours(sub.order, sub.tiles);
}

} // namespace talus::runtime
