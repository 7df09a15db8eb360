// runtime/phase/old_tiles.hpp: the tiles that were, while new ones are made from them. As soon as no new tile needs an old one, the
// memory of its lists serves the next new tile: so a rebuild holds little more than one copy of lists and histories.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "runtime/engine_state.hpp"

namespace talus::runtime {

/// Old tiles of a subdomain whose grains stand in new tiles, with their neighbours linked. The functions of a tile may be called for
/// different tiles at once; tiles near each other are best taken soon after each other.
class OldTiles {
public:
    explicit OldTiles(EngineState& s);
    /// Give a new tile, before its lists are made, memory that nobody needs, if there is any.
    void lend_memory(core::Tile& tile);
    /// Index by grain what new tile t looks contacts up in.
    void open(int t);
    /// New tile t is done.
    void close(int t);

private:
    Subdomain& sub_;
    std::vector<std::vector<int>> needed_;   // by new tile
    std::vector<std::atomic<int>> users_;    // of old ones, not yet done
    std::unique_ptr<std::once_flag[]> indexed_;
    std::vector<core::ContactsByGrain> spare_indexes_;
    std::mutex guard_; // of the spare tiles and indexes
};

} // namespace talus::runtime
