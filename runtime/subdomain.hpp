// runtime/subdomain.hpp: what one rank holds.
#pragma once

#include <vector>

#include "core/cells.hpp"
#include "core/contact_history.hpp"
#include "core/slice_grid.hpp"
#include "core/tile.hpp"

namespace talus::runtime {

/// What a chunk of a neighbour's grains (one of its tiles) was when the lists were built.
struct ChunkRange {
    core::Box place;    // m, of all grains of the tile, near this rank
    core::Box velocity; // m/s
};

struct Subdomain {
    std::vector<core::Particle> particles; // owned ones in tile-major order, then ghosts
    std::vector<core::Reference> references; // of the owned ones
    core::LocalIndex n_owned = 0;

    core::CellOrder order;
    std::vector<std::uint32_t> cell_first;
    std::vector<std::uint32_t> ghost_cell_first, ghost_order;
    std::vector<core::Vec3d> ghost_shift;
    std::vector<std::int32_t> ghost_chunk;
    std::vector<core::DisplacementBox> chunk_displacement; // as received
    std::vector<ChunkRange> chunk_range;

    std::vector<core::Tile> tiles;
    std::vector<core::Tile> spare_tiles;  // memory for lists to come
    core::HeatSum heat;                   // of tiles that are gone
    std::vector<core::WallSum> wall_last; // this rank's part of each wall's sums in the last force evaluation
    std::vector<core::Wide> wall_impulse; // [3 a wall] force units summed over steps since the work was last folded

    // Between empty_tiles and build_pairs there are no tiles, but those that were, and what waits for new ones; grain by grain, in the
    // order of `particles`.
    bool laid_out = false;
    std::vector<core::Tile> old_tiles;
    core::ContactStore contacts;          // of old_tiles, and of grains that came
    std::vector<std::uint32_t> slot_of;   // in it
    bool keeps_sums = true;               // no: forces are evaluated before anybody asks for them
    std::vector<core::ForceSum> sums;     // if kept

    /// Hold these grains and nothing else, laid out. Heat and sums of walls are the caller's to set.
    void hold(std::vector<core::Particle> grains, std::vector<core::Reference> references_of, std::vector<core::ForceSum> sums_of, core::ContactStore contacts_of);

    /// While laid out: keep the owned grains for which keep(i) holds, in their order, with all that stands beside them.
    template <class Keep>
    void keep_owned(Keep keep) {
        core::LocalIndex kept = 0;
        for (core::LocalIndex i = 0; i < n_owned; ++i) {
            if (!keep(i)) continue;
            if (kept == i) { // most that stay have not moved yet
                ++kept;
                continue;
            }
            particles[kept] = particles[i];
            references[kept] = references[i];
            if (keeps_sums) sums[kept] = sums[i];
            slot_of[kept] = slot_of[i];
            ++kept;
        }
        n_owned = kept;
        particles.resize(kept);
        references.resize(kept);
        if (keeps_sums) sums.resize(kept);
        slot_of.resize(kept);
    }

    core::LocalIndex n_ghosts() const { return static_cast<core::LocalIndex>(particles.size()) - n_owned; }
    struct Bytes {
        std::size_t records = 0;   // and displacement references
        std::size_t cells = 0;     // of grains and ghosts, and which grain is where in a tile
        std::size_t sums = 0;      // of forces
        std::size_t pairs = 0;     // contacts and candidates
        std::size_t histories = 0;
        std::size_t rebuild = 0;   // scratch of rebuilds, and lists' memory kept for the next one
        std::size_t total() const { return records + cells + sums + pairs + histories + rebuild; }
    };
    /// Memory held, used or not.
    Bytes bytes() const;
};

} // namespace talus::runtime
