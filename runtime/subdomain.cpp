#include "runtime/subdomain.hpp"

namespace talus::runtime {

std::size_t Subdomain::bytes() const {
    const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
    std::size_t b = of(particles) + of(references) + of(cell_first) + of(ghost_cell_first) + of(ghost_order) + of(ghost_shift) + of(ghost_chunk) + of(sums) + of(slot_of) + contacts.bytes();
    for (const core::Tile& t : tiles) b += sizeof(core::Tile) + t.bytes();
    return b;
}

} // namespace talus::runtime
