#include <algorithm>

#include "runtime/io/checkpoint.hpp"
#include "runtime/io/checkpoint_layout.hpp"
#include "runtime/io/seal.hpp"
#include "runtime/io/state_fields.hpp"
#include "runtime/io/vtkhdf.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::runtime {

namespace {

constexpr int kCountBlock = 8192; // grains a task

/// Contacts of this rank, grain after grain, partners ascending: no trace of the order of lists. They are looked up when they are
/// written, block by block: a list of all would be the most memory that a rank ever needs.
struct LaidOut {
    struct Contact {
        core::Label partner;
        core::HistoryPlace place;
    };
    core::ContactStore own;
    const core::ContactStore* store = nullptr;
    const std::vector<std::uint32_t>* slot_of = nullptr; // NULL: a grain's slot is its index
    std::vector<std::uint32_t> number;                   // [n_owned] contacts of each grain
    std::vector<std::uint64_t> first;                    // [n_owned + 1]

    template <class Visit>
    void each(std::size_t i, Visit visit) const {
        store->each(slot_of != nullptr ? (*slot_of)[i] : static_cast<std::uint32_t>(i), visit);
    }
    /// visit(k, contact) for rows row + k, 0 <= k < n.
    template <class Visit>
    void each_row(std::uint64_t row, std::uint64_t n, Visit visit) const {
        std::vector<Contact> of_grain;
        std::uint64_t at = row;
        for (std::size_t i = static_cast<std::size_t>(std::upper_bound(first.begin(), first.end(), row) - first.begin()) - 1; at < row + n; ++i) {
            of_grain.clear();
            each(i, [&](core::Label partner, const core::HistoryPlace& place) { of_grain.push_back({partner, place}); });
            std::sort(of_grain.begin(), of_grain.end(), [](const Contact& a, const Contact& b) { return a.partner < b.partner; });
            for (; at < std::min(row + n, first[i + 1]); ++at) visit(at - row, of_grain[at - first[i]]);
        }
    }
};

void lay_out(EngineState& s, LaidOut& out) {
    Subdomain& sub = s.sub;
    if (!sub.laid_out) {
        lay_out_contacts(s, out.own);
        out.store = &out.own;
    } else {
        out.store = &sub.contacts;
        out.slot_of = &sub.slot_of;
        for (const std::uint32_t slot : sub.slot_of) sub.contacts.open(slot);
    }
    out.number.assign(sub.n_owned, 0);
    s.workers.for_each(Phase::observe, static_cast<int>((sub.n_owned + kCountBlock - 1) / kCountBlock), [&](int block) {
        const auto begin = static_cast<std::uint32_t>(block) * kCountBlock;
        for (std::uint32_t i = begin; i < std::min<std::uint32_t>(begin + kCountBlock, sub.n_owned); ++i)
            out.each(i, [&](core::Label, const core::HistoryPlace&) { ++out.number[i]; });
    });
    out.first.assign(std::size_t{sub.n_owned} + 1, 0);
    for (std::uint32_t i = 0; i < sub.n_owned; ++i) out.first[i + 1] = out.first[i] + out.number[i];
    TALUS_CHECK(sub.references.size() >= sub.n_owned && (!sub.laid_out || (sub.keeps_sums && sub.sums.size() == sub.n_owned)));
    // Material, group and colour are all that meta holds; whatever is added to it needs a place in the format.
    for (std::uint32_t i = 0; i < sub.n_owned; ++i) TALUS_CHECK(sub.particles[i].meta >> 24 == 0);
}

Totals sum_totals(EngineState& s) {
    const Subdomain& sub = s.sub;
    core::HeatSum heat = sub.heat;
    for (const core::Tile& tile : sub.tiles) {
        heat.friction += tile.heat.friction;
        heat.damping += tile.heat.damping;
        heat.rolling += tile.heat.rolling;
    }
    const std::size_t walls = s.model.walls.size();
    Totals t;
    t.wall_last = sub.wall_last;
    t.wall_last.resize(walls);
    t.wall_impulse = sub.wall_impulse;
    t.wall_impulse.resize(3 * walls);
    core::Wide of_heat[3] = {heat.friction, heat.damping, heat.rolling};
    s.comm->sum(of_heat, 3);
    t.heat = {of_heat[0], of_heat[1], of_heat[2]};
    for (core::WallSum& w : t.wall_last) {
        s.comm->sum(w.force, 3);
        s.comm->sum(w.torque, 3);
        w.contacts = s.comm->sum(w.contacts);
    }
    if (walls > 0) s.comm->sum(t.wall_impulse.data(), static_cast<int>(t.wall_impulse.size()));
    return t;
}

std::vector<Column> contact_columns(const LaidOut& laid, const Rows& rows) {
    const auto partner = [&laid](std::uint64_t row, std::uint64_t n, std::byte* bytes) {
        laid.each_row(row, n, [&](std::uint64_t k, const LaidOut::Contact& c) { std::memcpy(bytes + k * sizeof(core::Label), &c.partner, sizeof(core::Label)); });
    };
    const auto doubles = static_cast<std::size_t>(laid.store->history_doubles);
    const auto history = [&laid, doubles](std::uint64_t row, std::uint64_t n, std::byte* bytes) {
        double values[core::kMaxHistoryDoubles];
        laid.each_row(row, n, [&](std::uint64_t k, const LaidOut::Contact& c) {
            laid.store->get(c.place, values);
            std::memcpy(bytes + k * doubles * sizeof(double), values, doubles * sizeof(double));
        });
    };
    std::vector<Column> columns{{kContactPartner, "", Kind::i64, 0, rows, partner}};
    if (doubles > 0) columns.push_back({kContactHistory, "", Kind::f64, doubles, rows, history});
    return columns;
}

void add_head(Hdf5File& hdf5) {
    const auto format = static_cast<std::int64_t>(kCheckpointFormat);
    hdf5.add_text("/", "format", kFormatName);
    hdf5.add_attribute("/", "format_version", Kind::i64, {}, &format);
    hdf5.add_text("/", "talus_version", TALUS_VERSION_TEXT);
#if defined(__clang__)
    hdf5.add_text("/", "build", __VERSION__);
#else
    hdf5.add_text("/", "build", "GCC " __VERSION__);
#endif
}

} // namespace

void save_checkpoint(EngineState& s, const std::string& path) {
    Subdomain& sub = s.sub;
    LaidOut laid;
    agree(*s.comm, [&] { lay_out(s, laid); });
    const std::vector<std::int64_t> grains = count_by_rank(*s.comm, sub.n_owned), contacts = count_by_rank(*s.comm, laid.first.back());
    const Rows grain_rows = rows_in_rank_order(grains, s.comm->rank());
    const Totals totals = sum_totals(s);

    NewFile file;
    file.path = path;
    file.sealed = true;
    file.columns = grain_columns({sub.particles.data(), sub.references.data(), sub.laid_out ? sub.sums.data() : nullptr, sub.tiles}, grain_rows, true);
    file.columns.push_back(plain_column(kContactNumber, Kind::u32, 0, grain_rows, laid.number.data(), true));
    for (Column& c : vtk_columns(*s.comm, grain_rows)) file.columns.push_back(std::move(c));
    for (Column& c : contact_columns(laid, rows_in_rank_order(contacts, s.comm->rank()))) file.columns.push_back(std::move(c));
    file.lay_out = [&](Hdf5File& hdf5) {
        add_head(hdf5);
        put_fields(s.model, s.force.pairs, totals, [&](const std::string& name, const std::string& unit, Kind kind, const Shape& shape, const std::uint64_t* words) {
            hdf5.add_dataset(kState + name, kind, shape, words, unit);
        });
        hdf5.add_group("/contacts");
        hdf5.add_text("/contacts", "partner", "label of the other grain, or 2^62 + number of the wall");
        add_vtk_header(hdf5, grains, s.model.time);
        add_vtk_points(hdf5, "/grains/position");
        for (const char* name : {"label", "radius", "mass", "velocity", "angular_velocity", "material", "group", "colour"}) add_vtk_point_array(hdf5, name, std::string(kGrains) + name);
    };
    write_file(s, file);
    for (core::Tile& t : sub.tiles) t.by_grain = core::ContactsByGrain{};
}

} // namespace talus::runtime
