#include "apps/bench/traffic.hpp"

#include "apps/bench/lists.hpp"

namespace talus::bench {

namespace {

constexpr double kLine = 64.0;
constexpr double kRecord = sizeof(core::Particle), kSum = sizeof(core::ForceSum), kIndex = sizeof(core::LocalIndex), kReference = sizeof(core::Reference);
constexpr double kLabel = sizeof(core::Label);

} // namespace

Traffic traffic(const runtime::EngineState& s) {
    const core::Laws& laws = s.model.settings.laws;
    const double row = core::history_doubles(laws) * static_cast<double>(sizeof(double));
    ListCounts lists = count_pairs(s);
    lists += count_walls(s);
    double own = 0.0, ids = 0.0, border = 0.0;
    for (const core::Tile& tile : s.sub.tiles) {
        own += tile.count;
        ids += static_cast<double>(tile.index_of.size());
        for (const core::IncomingSums& in : tile.incoming) border += in.count;
    }
    Traffic t;
    // An index and both lines of a record are read for every grain that a tile knows, and its sums are written; lists are passed through.
    t.force = ids * (kIndex + kRecord + kSum) + force_bytes(lists, row);
    // Records are read and written, sums read; border rows are read by way of their index. References are touched by wraps alone.
    t.integrate = own * (2.0 * kRecord + kSum) + border * (kIndex + kSum);
    // Cell numbers from positions; the counting sort with its labels; records, references and places brought into the new order, each by
    // way of a scratch.
    t.binning = own * ((kLine + kIndex) + (2.0 * kIndex + kLine) + 4.0 * (kRecord + kReference + kIndex) + 4.0 * kIndex);
    // Labels are set aside and contacts indexed; records of all that a tile knows are read; entries are read back; new lists are written,
    // with rows out of the old ones. Records are marked.
    t.pair_build = own * (kLine + kLabel) + index_bytes(lists) + ids * (2.0 * kIndex + kRecord) + lists.contacts * 2.0 * kEntryBytes + list_bytes(lists, row) +
                   own * 2.0 * kLine;
    return t;
}

} // namespace talus::bench
