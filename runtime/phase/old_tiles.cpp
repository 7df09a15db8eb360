#include "runtime/phase/old_tiles.hpp"

#include <algorithm>

namespace talus::runtime {

namespace {

void sort_unique(std::vector<int>& v) {
    std::sort(v.begin(), v.end());
    v.erase(std::unique(v.begin(), v.end()), v.end());
}

} // namespace

OldTiles::OldTiles(EngineState& s)
    : sub_(s.sub), needed_(sub_.tiles.size()), users_(sub_.old_tiles.size()), indexed_(std::make_unique<std::once_flag[]>(sub_.old_tiles.size())) {
    const core::ContactStore& store = sub_.contacts;
    const int n = static_cast<int>(sub_.tiles.size());
    std::vector<std::vector<int>> of_grains(needed_.size()); // old tiles of a new one's own grains
    s.workers.for_each(Phase::pair_build, n, [&](int t) {
        const core::Tile& tile = sub_.tiles[t];
        std::vector<int>& from = of_grains[t];
        const core::Tile* last = nullptr;
        for (core::LocalIndex i = tile.first; i < tile.first + tile.count; ++i) {
            const std::uint32_t slot = sub_.slot_of[i];
            if (slot >= store.n_grains || (last != nullptr && slot >= last->first && slot < last->first + last->count)) continue;
            last = &store.tile_of(slot);
            from.push_back(static_cast<int>(last - sub_.old_tiles.data()));
        }
        sort_unique(from);
    });
    s.workers.for_each(Phase::pair_build, n, [&](int t) {
        std::vector<int>& needs = needed_[t];
        const auto add = [&](const std::vector<int>& more) { needs.insert(needs.end(), more.begin(), more.end()); };
        add(of_grains[t]);
        for (const int u : sub_.tiles[t].neighbours) add(of_grains[u]);
        // A partner that is a ghost now may have stood in any tile around.
        for (const int u : of_grains[t]) add(sub_.old_tiles[u].neighbours);
        sort_unique(needs);
        for (const int u : needs) users_[u].fetch_add(1, std::memory_order_relaxed);
    });
}

void OldTiles::lend_memory(core::Tile& tile) {
    const std::lock_guard lock(guard_);
    if (sub_.spare_tiles.empty()) return;
    tile.swap_memory(sub_.spare_tiles.back());
    sub_.spare_tiles.pop_back();
}

void OldTiles::open(int t) {
    for (const int u : needed_[t])
        std::call_once(indexed_[u], [&] {
            core::Tile& tile = sub_.old_tiles[u];
            if (tile.by_grain.first.empty()) {
                const std::lock_guard lock(guard_);
                if (!spare_indexes_.empty()) {
                    tile.by_grain = std::move(spare_indexes_.back());
                    spare_indexes_.pop_back();
                }
            }
            core::index_contacts(sub_.contacts.labels, tile);
        });
}

void OldTiles::close(int t) {
    for (const int u : needed_[t]) {
        if (users_[u].fetch_sub(1, std::memory_order_acq_rel) != 1) continue;
        core::Tile& old = sub_.old_tiles[u];
        core::Tile spare;
        spare.swap_memory(old);
        old.by_grain.first.clear();
        const std::lock_guard lock(guard_);
        sub_.spare_tiles.push_back(std::move(spare));
        spare_indexes_.push_back(std::move(old.by_grain));
    }
}

} // namespace talus::runtime
