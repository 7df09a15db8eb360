#include "runtime/subdomain.hpp"

namespace talus::runtime {

Subdomain::Bytes Subdomain::bytes() const {
    const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
    Bytes b;
    b.records = of(particles) + of(references);
    b.cells = of(cell_first) + of(ghost_cell_first) + of(ghost_order) + of(ghost_shift) + of(ghost_chunk);
    b.rebuild = of(sums) + of(slot_of) + of(slices) + contacts.bytes();
    for (const auto* all : {&tiles, &spare_tiles})
        for (const core::Tile& t : *all) {
            b.cells += sizeof(core::Tile) + of(t.index_of);
            b.sums += of(t.sums);
            const auto add = [&](const core::ContactList& list) {
                b.histories += of(list.history);
                b.pairs += list.bytes() - of(list.history);
            };
            add(t.pairs);
            for (const auto& w : t.walls) add(w);
        }
    return b;
}

} // namespace talus::runtime
