#include <algorithm>
#include <limits>
#include <optional>
#include <string_view>

#include "runtime/comm/packing_buffer.hpp"
#include "runtime/io/checkpoint.hpp"
#include "runtime/io/checkpoint_check.hpp"
#include "runtime/io/checkpoint_layout.hpp"
#include "runtime/io/seal.hpp"

namespace talus::runtime {

using core::ErrorKind;
using core::fail;

namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& fault) { fail(ErrorKind::io, "{}: cannot be a saved state: {}", path, fault); }

/// Rank 0: the words of /state in the order of take_fields(), and the sealed columns.
struct Head {
    std::vector<std::uint64_t> words;
    std::vector<SealedColumn> columns;
};

Head read_head(const DiskFile& disk, const Model& like) {
    const std::string& path = disk.path();
    FileImage image;
    Head head;
    head.columns = read_seal(disk, image).columns;
    const Hdf5File hdf5(path, std::move(image));
    if (hdf5.read_text("/", "format") != kFormatName) fail(ErrorKind::io, "{}: is not a checkpoint of Talus", path);
    Model model = like;
    PairTable pairs;
    Totals totals;
    take_fields(
        [&](const std::string& name, Kind kind, const Shape& shape, std::uint64_t* words) {
            hdf5.read_dataset(kState + name, kind, shape, words);
            head.words.insert(head.words.end(), words, words + items_of(shape));
        },
        model, pairs, totals);
    // What HDF5 says of the bulk must be what was sealed.
    const auto compare = [&](const std::string& name, Kind kind, std::uint64_t width) {
        const Place place = hdf5.find(name, kind, width);
        const auto found = std::find_if(head.columns.begin(), head.columns.end(), [&](const SealedColumn& c) { return name == c.name; });
        if (found == head.columns.end() || found->place.rows != place.rows || found->place.row_bytes != place.row_bytes || found->place.offset != place.offset)
            fail(ErrorKind::io, "{}: dataset {} is not the one that was sealed", path, name);
    };
    for (const GrainColumn& g : kGrainColumns) compare(kGrains + std::string(g.name), g.kind, g.width);
    compare(kContactNumber, Kind::u32, 0);
    compare(kContactPartner, Kind::i64, 0);
    if (const int doubles = core::history_doubles(model.settings.laws); doubles > 0) compare(kContactHistory, Kind::f64, static_cast<std::uint64_t>(doubles));
    return head;
}

template <class T>
void broadcast(Communicator& comm, std::vector<T>& items) {
    std::uint64_t n = items.size();
    comm.broadcast(&n, sizeof n, 0);
    items.resize(n);
    comm.broadcast(items.data(), n * sizeof(T), 0);
}

/// Rows of `columns` into memory, and their digests against the seal. [collective]
void read_columns(EngineState& s, const DiskFile& disk, const Seal& seal, const std::vector<Column>& columns) {
    std::vector<core::Digest> digests;
    agree(*s.comm, [&] {
        std::vector<Place> places;
        for (const Column& c : columns) {
            const SealedColumn* sealed = seal.find(c.name);
            if (sealed == nullptr || sealed->place.rows != c.rows.total || sealed->place.row_bytes != c.row_bytes()) fail(ErrorKind::io, "{}: dataset {} has not the length it should have", disk.path(), c.name);
            places.push_back(sealed->place);
        }
        digests = read_rows(s.workers, disk, columns, places);
    });
    sum_over_ranks(*s.comm, digests);
    agree(*s.comm, [&] {
        for (std::size_t c = 0; c < columns.size(); ++c) {
            const core::Digest stored = seal.find(columns[c].name)->digest;
            if (stored.lo != digests[c].lo || stored.hi != digests[c].hi) fail(ErrorKind::io, "{}: is damaged: the bytes of dataset {} do not give the stored digest", disk.path(), columns[c].name);
        }
    });
}

/// This rank's share, until all of it has been checked.
struct Share {
    std::vector<core::Particle> grains;
    std::vector<core::Reference> references;
    std::vector<core::ForceSum> sums;
    core::ContactStore contacts;
};

/// Contacts of grains whose numbers of contacts are known. [collective]
void read_contacts(EngineState& s, const DiskFile& disk, const Seal& seal, const Model& model, const std::vector<std::uint32_t>& number, core::ContactStore& out) {
    std::uint64_t mine = 0;
    for (const std::uint32_t n : number) mine += n;
    const Rows rows = rows_in_rank_order(count_by_rank(*s.comm, mine), s.comm->rank());
    std::vector<core::Label> partners;
    std::vector<double> history;
    const int doubles = core::history_doubles(model.settings.laws);
    agree(*s.comm, [&] {
        const SealedColumn* sealed = seal.find(kContactPartner);
        if (sealed == nullptr || sealed->place.rows != rows.total) refuse(disk.path(), fmt::format("grains have {} contacts in all, but {} are stored", rows.total, sealed == nullptr ? 0 : sealed->place.rows));
        if (rows.count > std::numeric_limits<std::uint32_t>::max()) fail(ErrorKind::capacity, "{}: {} contacts for one rank are too many; use more ranks", disk.path(), rows.count);
        partners.resize(rows.count);
        history.resize(rows.count * static_cast<std::uint64_t>(doubles));
    });
    std::vector<Column> columns{plain_column(kContactPartner, Kind::i64, 0, rows, partners.data(), false)};
    if (doubles > 0) columns.push_back(plain_column(kContactHistory, Kind::f64, static_cast<std::uint64_t>(doubles), rows, history.data(), false));
    read_columns(s, disk, seal, columns);
    agree(*s.comm, [&] {
        out = core::ContactStore{};
        out.history_doubles = doubles;
        out.first.reserve(number.size() + 1);
        out.partners.reserve(partners.size());
        out.rows.reserve(history.size());
        std::uint64_t at = 0;
        for (const std::uint32_t n : number) {
            out.append(partners.data() + at, history.data() + at * static_cast<std::uint64_t>(doubles), n);
            at += n;
        }
    });
}

/// What ParaView alone reads is checked as well, so that no changed bit goes unseen.
std::vector<Column> other_columns(const Communicator& comm, const Seal& seal, const std::vector<Column>& known) {
    std::vector<Column> columns;
    for (const SealedColumn& c : seal.columns) {
        const auto same = [&](const Column& k) { return k.name == c.name; };
        if (std::any_of(known.begin(), known.end(), same) || std::string_view(c.name).starts_with("/contacts/")) continue;
        columns.push_back({c.name, "", Kind::u8, c.place.row_bytes, share_of_rows(comm, c.place.rows), [](std::uint64_t, std::uint64_t, std::byte*) {}});
    }
    return columns;
}

void load(EngineState& s, const std::string& path) {
    Communicator& comm = *s.comm;
    std::optional<DiskFile> disk;
    Head head;
    agree(comm, [&] {
        disk = DiskFile::open_to_read(path);
        if (comm.rank() == 0) head = read_head(*disk, s.model);
    });
    broadcast(comm, head.words);
    broadcast(comm, head.columns);

    const Seal seal{std::move(head.columns)};
    Model model = s.model;
    PairTable pairs;
    Totals totals;
    Share share;
    std::vector<std::uint32_t> number;
    Rows rows;
    agree(comm, [&] {
        std::size_t at = 0;
        take_fields(
            [&](const std::string&, Kind, const Shape& shape, std::uint64_t* words) {
                const std::uint64_t n = items_of(shape);
                TALUS_CHECK(at + n <= head.words.size());
                std::copy_n(head.words.data() + at, n, words);
                at += n;
            },
            model, pairs, totals);
        if (const std::string faults = model_faults(model, pairs); !faults.empty()) refuse(path, faults);
        rows = share_of_rows(comm, static_cast<std::uint64_t>(model.n_particles));
        const std::uint64_t grains = seal.find("/grains/label")->place.rows;
        if (grains != rows.total) refuse(path, fmt::format("it holds {} grains, but says {}", grains, rows.total));
        if (rows.count > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max())) fail(ErrorKind::capacity, "{}: {} grains for one rank are too many; use more ranks", path, rows.count);
        share.grains.resize(rows.count);
        share.references.resize(rows.count);
        share.sums.resize(rows.count);
        number.resize(rows.count);
    });
    std::vector<Column> columns = grain_columns({share.grains.data(), share.references.data(), share.sums.data()}, rows, false);
    columns.push_back(plain_column(kContactNumber, Kind::u32, 0, rows, number.data(), false));
    for (Column& c : other_columns(comm, seal, columns)) columns.push_back(std::move(c));
    read_columns(s, *disk, seal, columns);
    agree(comm, [&] {
        if (const std::string fault = grain_fault(model, share.grains, share.references); !fault.empty()) refuse(path, fault);
    });
    read_contacts(s, *disk, seal, model, number, share.contacts);
    agree(comm, [&] {
        if (const std::string fault = contact_fault(model, share.grains, share.contacts); !fault.empty()) refuse(path, fault);
    });
    if (const std::string fault = pairing_fault(comm, share.grains, share.contacts); !fault.empty()) refuse(path, fault);

    // All is well: take it. Totals over ranks go to one of them.
    if (comm.rank() != 0) {
        totals.heat = core::HeatSum{};
        totals.wall_last.assign(totals.wall_last.size(), core::WallSum{});
        totals.wall_impulse.assign(totals.wall_impulse.size(), core::Wide{0});
    }
    for (Wall& w : model.walls) w.listed_point = w.plane.point;
    s.model = std::move(model);
    std::copy(&pairs[0][0], &pairs[0][0] + core::kMaxMaterials * core::kMaxMaterials, &s.force.pairs[0][0]);
    Subdomain& sub = s.sub;
    sub.hold(std::move(share.grains), std::move(share.references), std::move(share.sums), std::move(share.contacts));
    sub.heat = totals.heat;
    sub.wall_last = std::move(totals.wall_last);
    sub.wall_impulse = std::move(totals.wall_impulse);
}

} // namespace

void load_checkpoint(EngineState& s, const std::string& path) {
    try {
        load(s, path);
    } catch (const core::Error& e) {
        if (e.kind() != ErrorKind::io) throw;
        std::string text = e.what();
        if (!text.starts_with(path)) text = path + ": " + text;
        if (file_exists(previous_name(path))) text += ". The checkpoint before it is " + previous_name(path);
        throw core::Error(ErrorKind::io, text);
    }
}

} // namespace talus::runtime
