#include "runtime/subdomain.hpp"

#include <numeric>

namespace talus::runtime {

Subdomain::Bytes Subdomain::bytes() const {
    const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
    Bytes b;
    b.records = of(particles) + of(references);
    b.cells = of(cell_first) + of(ghost_cell_first) + of(ghost_order) + of(ghost_shift) + of(ghost_chunk);
    b.rebuild = of(sums) + of(slot_of) + contacts.bytes();
    const auto of_tile = [&](const core::Tile& t) {
        Bytes o;
        o.cells = sizeof(core::Tile) + of(t.index_of);
        o.sums = of(t.sums);
        const auto add = [&](const core::ContactList& list) {
            o.histories += of(list.history);
            o.pairs += list.bytes() - of(list.history);
        };
        add(t.pairs);
        for (const auto& w : t.walls) add(w);
        o.rebuild = of(t.by_grain.first) + of(t.by_grain.number) + of(t.by_grain.key);
        return o;
    };
    for (const core::Tile& t : tiles) {
        const Bytes o = of_tile(t);
        b.cells += o.cells;
        b.sums += o.sums;
        b.pairs += o.pairs;
        b.histories += o.histories;
        b.rebuild += o.rebuild;
    }
    for (const auto* idle : {&spare_tiles, &old_tiles})
        for (const core::Tile& t : *idle) b.rebuild += of_tile(t).total();
    return b;
}

void Subdomain::hold(std::vector<core::Particle> grains, std::vector<core::Reference> references_of, std::vector<core::ForceSum> sums_of, core::ContactStore contacts_of) {
    *this = Subdomain{};
    n_owned = static_cast<core::LocalIndex>(grains.size());
    particles = std::move(grains);
    references = std::move(references_of);
    sums = std::move(sums_of);
    keeps_sums = true;
    contacts = std::move(contacts_of);
    slot_of.resize(n_owned);
    std::iota(slot_of.begin(), slot_of.end(), 0u);
    laid_out = true;
}

} // namespace talus::runtime
