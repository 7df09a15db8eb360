#include "runtime/comm/halo.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>

#include "runtime/comm/mpi_handle.hpp"
#include "runtime/comm/packing_buffer.hpp"
#include "runtime/large_array.hpp"

namespace talus::runtime {

using core::Box;
using core::DisplacementBox;
using core::LocalIndex;
using core::Particle;

namespace {

constexpr int kGhostDoubles = 12;            // position, radius, velocity, mass, angular velocity, meta
constexpr std::uint32_t kPart = 1024;        // ghosts that a node writes
constexpr int kBoxDoubles = 12;              // a DisplacementBox
static_assert(sizeof(DisplacementBox) == kBoxDoubles * sizeof(double));
static_assert(offsetof(Particle, listed_position) == kGhostDoubles * sizeof(double));

/// A rank and the image of it that lies near.
struct Neighbour {
    int rank;
    core::Vec3d shift; // to be added to my positions to come near that rank
    Box box;           // its subdomain, widened by the reach
};

/// Whether two boxes, one of them shifted, are nearer to each other along an axis than `distance`.
bool near_along(int axis, const Box& a, const core::Vec3d& shift, const Box& b, double distance) {
    const double s[3] = {shift.x, shift.y, shift.z};
    return a.lo[axis] + s[axis] <= b.hi[axis] + distance && a.hi[axis] + s[axis] >= b.lo[axis] - distance;
}

/// Whether two boxes, one of them shifted, are nearer to each other than `distance` on every axis.
bool near(const Box& a, const core::Vec3d& shift, const Box& b, double distance) {
    return near_along(0, a, shift, b, distance) && near_along(1, a, shift, b, distance) && near_along(2, a, shift, b, distance);
}

void extend(Box& b, const double (&x)[3]) {
    for (int a = 0; a < 3; ++a) {
        b.lo[a] = std::min(b.lo[a], x[a]);
        b.hi[a] = std::max(b.hi[a], x[a]);
    }
}
constexpr Box kEmptyBox{{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};

/// Positions and velocities of a tile's grains.
ChunkRange range_of(const core::Tile& tile, const std::vector<Particle>& particles) {
    ChunkRange r{kEmptyBox, kEmptyBox};
    for (LocalIndex i = tile.first; i < tile.first + tile.count; ++i) {
        extend(r.place, particles[i].position);
        extend(r.velocity, particles[i].velocity);
    }
    return r;
}

/// A subdomain with finite ends on periodic axes: beyond them lies an image, not more of the same rank.
Box bounded_box(const core::SliceGrid& slices, const core::Domain& domain, int rank) {
    Box b = slices.box(rank);
    for (int a = 0; a < 3; ++a) {
        if (!domain.periodic[a]) continue;
        if (std::isinf(b.lo[a])) b.lo[a] = domain.lo[a];
        if (std::isinf(b.hi[a])) b.hi[a] = domain.hi[a];
    }
    return b;
}

/// The ranks whose widened subdomains come near mine, and the images of them: slab by slab, so that far ones are not looked at.
std::vector<Neighbour> find_neighbours(const core::SliceGrid& slices, const core::Domain& domain, double reach, int me) {
    const auto& grid = slices.grid();
    const auto widened = [&](int rank) {
        Box box = bounded_box(slices, domain, rank);
        for (int a = 0; a < 3; ++a) {
            if (domain.periodic[a] && grid[a] == 1) {
                box.lo[a] = -HUGE_VAL;
                box.hi[a] = HUGE_VAL;
            }
            box.lo[a] -= reach;
            box.hi[a] += reach;
        }
        return box;
    };
    std::vector<Neighbour> out;
    const Box mine = bounded_box(slices, domain, me);
    const auto look = [&](const core::Vec3d& shift) {
        for (int x = 0; x < grid[0]; ++x) {
            if (!near_along(0, mine, shift, widened(slices.rank_at(x, 0, 0)), reach)) continue;
            for (int z = 0; z < grid[2]; ++z) {
                if (!near_along(2, mine, shift, widened(slices.rank_at(x, 0, z)), reach)) continue;
                for (int y = 0; y < grid[1]; ++y) {
                    const int rank = slices.rank_at(x, y, z);
                    const bool self = rank == me && shift.x == 0.0 && shift.y == 0.0 && shift.z == 0.0;
                    const Box box = widened(rank);
                    if (!self && near_along(1, mine, shift, box, reach)) out.push_back({rank, shift, box});
                }
            }
        }
    };
    // An axis that is not cut wraps in the cells of its owner.
    const auto images = [&](int a) { return domain.periodic[a] && grid[a] > 1 ? 1 : 0; };
    for (int ix = -images(0); ix <= images(0); ++ix)
        for (int iy = -images(1); iy <= images(1); ++iy)
            for (int iz = -images(2); iz <= images(2); ++iz) look({ix * domain.length(0), iy * domain.length(1), iz * domain.length(2)});
    return out;
}

bool test_all(std::vector<MPI_Request>& requests) {
    int done = 1;
    if (!requests.empty()) check_mpi(MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE), "MPI_Testall");
    return done != 0;
}

bool inside(const Box& b, const double* x, const core::Vec3d& s) {
    return x[0] + s.x >= b.lo[0] && x[0] + s.x <= b.hi[0] && x[1] + s.y >= b.lo[1] && x[1] + s.y <= b.hi[1] && x[2] + s.z >= b.lo[2] && x[2] + s.z <= b.hi[2];
}

} // namespace

struct Halo::Send {
    int rank;
    std::vector<LocalIndex> grains;
    std::vector<core::Vec3d> shifts;
    std::vector<int> tiles;               // a tile a chunk
    std::vector<std::uint32_t> chunk_end; // grains before the end of each chunk
    std::vector<ChunkRange> ranges;       // a chunk; places as the receiver sees them
    std::vector<double> buffer;
};

struct Halo::Receive {
    int rank;
    LocalIndex first;            // ghost number of its first grain
    std::uint32_t count;
    std::int32_t first_chunk;
    std::uint32_t n_chunks;
    std::vector<double> buffer;
};

/// Grains of a message that one node writes; the last part of a message brings its chunks too.
struct Halo::Part {
    std::size_t receive;
    std::uint32_t first, end;
};

struct Halo::Requests {
    std::vector<MPI_Request> sends, receives;
    std::mutex guard; // sends come from any worker
};

Halo::Halo(Communicator& comm) : comm_(comm), requests_(std::make_unique<Requests>()) {}
Halo::~Halo() {
    int finalised = 0;
    if (comm_.size() > 1) MPI_Finalized(&finalised);
    if (!finalised) release();
}

bool Halo::talks() const { return !sends_.empty() || !receives_.empty(); }
int Halo::n_neighbours() const { return static_cast<int>(sends_.size()); }
const std::vector<int>& Halo::tiles_of(int k) const { return sends_[k].tiles; }

void Halo::release() {
    for (auto* list : {&requests_->sends, &requests_->receives}) {
        for (MPI_Request& r : *list)
            if (r != MPI_REQUEST_NULL) MPI_Request_free(&r);
        list->clear();
    }
}

void Halo::build(const core::SliceGrid& slices, const core::Domain& domain, double reach, Subdomain& sub) {
    release();
    sends_.clear();
    receives_.clear();
    parts_.clear();
    sub.particles.resize(sub.n_owned);
    sub.ghost_shift.clear();
    sub.ghost_chunk.clear();
    sub.chunk_displacement.clear();
    sub.chunk_range.clear();
    if (comm_.size() == 1) return;

    // Which of my grains lie within reach of which images of which ranks.
    const std::vector<Neighbour> neighbours = find_neighbours(slices, domain, reach, comm_.rank());
    const Box mine = bounded_box(slices, domain, comm_.rank());
    std::vector<int> send_of(static_cast<std::size_t>(comm_.size()), -1);
    for (std::size_t t = 0; t < sub.tiles.size(); ++t) {
        const core::Tile& tile = sub.tiles[t];
        if (tile.count == 0) continue;
        const ChunkRange range = range_of(tile, sub.particles);
        for (const Neighbour& n : neighbours) {
            if (!near(range.place, n.shift, n.box, reach)) continue;
            if (send_of[n.rank] < 0) {
                send_of[n.rank] = static_cast<int>(sends_.size());
                sends_.push_back(Send{n.rank, {}, {}, {}, {}, {}, {}});
            }
            Send& s = sends_[send_of[n.rank]];
            if (s.tiles.empty() || s.tiles.back() != static_cast<int>(t)) {
                s.tiles.push_back(static_cast<int>(t));
                s.chunk_end.push_back(static_cast<std::uint32_t>(s.grains.size()));
                s.ranges.push_back({kEmptyBox, range.velocity});
            }
            const double shift[3] = {n.shift.x, n.shift.y, n.shift.z};
            for (const auto* corner : {&range.place.lo, &range.place.hi}) {
                const double at[3] = {(*corner)[0] + shift[0], (*corner)[1] + shift[1], (*corner)[2] + shift[2]};
                extend(s.ranges.back().place, at);
            }
        }
        for (LocalIndex i = tile.first; i < tile.first + tile.count; ++i) {
            const double* x = sub.particles[i].position;
            bool interior = true;
            for (int a = 0; a < 3; ++a) {
                const bool wraps = domain.periodic[a] && slices.grid()[a] == 1;
                interior = interior && (wraps || (x[a] - mine.lo[a] > reach && mine.hi[a] - x[a] > reach));
            }
            if (interior) continue;
            for (const Neighbour& n : neighbours) {
                if (!inside(n.box, x, n.shift)) continue;
                Send& s = sends_[send_of[n.rank]];
                s.grains.push_back(i);
                s.shifts.push_back(n.shift);
                s.chunk_end.back() = static_cast<std::uint32_t>(s.grains.size());
            }
        }
    }

    std::vector<Parcel> parcels;
    for (const Send& s : sends_) {
        Packer pack;
        pack.put(static_cast<std::uint32_t>(s.grains.size()));
        pack.put_all(s.chunk_end);
        pack.put_all(s.ranges);
        for (std::size_t k = 0; k < s.grains.size(); ++k) {
            pack.put(sub.particles[s.grains[k]]);
            pack.put(s.shifts[k]);
        }
        parcels.push_back({s.rank, pack.take()});
    }
    for (const Parcel& p : comm_.sparse_exchange(std::move(parcels))) {
        Unpacker unpack(p.data);
        const auto n = unpack.get<std::uint32_t>();
        const auto chunk_end = unpack.get_all<std::uint32_t>();
        const auto ranges = unpack.get_all<ChunkRange>();
        sub.chunk_range.insert(sub.chunk_range.end(), ranges.begin(), ranges.end());
        Receive r{p.rank, static_cast<LocalIndex>(sub.ghost_shift.size()), n, static_cast<std::int32_t>(sub.chunk_displacement.size()), static_cast<std::uint32_t>(chunk_end.size()), {}};
        make_large_room(sub.particles, sub.particles.size() + n);
        for (std::uint32_t k = 0, chunk = 0; k < n; ++k) {
            while (k >= chunk_end[chunk]) ++chunk;
            sub.particles.push_back(unpack.get<Particle>());
            sub.ghost_shift.push_back(unpack.get<core::Vec3d>());
            sub.ghost_chunk.push_back(r.first_chunk + static_cast<std::int32_t>(chunk));
        }
        sub.chunk_displacement.resize(sub.chunk_displacement.size() + chunk_end.size());
        receives_.push_back(std::move(r));
    }

    // Requests last until the next build. A message to oneself goes through MPI like any other.
    const MPI_Comm mpi = comm_.handle()->comm;
    for (Send& s : sends_) {
        s.buffer.resize(s.grains.size() * kGhostDoubles + s.tiles.size() * kBoxDoubles);
        requests_->sends.emplace_back();
        check_mpi(MPI_Send_init(s.buffer.data(), static_cast<int>(s.buffer.size()), MPI_DOUBLE, s.rank, kHaloTag, mpi, &requests_->sends.back()), "MPI_Send_init");
    }
    for (Receive& r : receives_) {
        r.buffer.resize(static_cast<std::size_t>(r.count) * kGhostDoubles + r.n_chunks * kBoxDoubles);
        for (std::uint32_t first = 0; first == 0 || first < r.count; first += kPart) parts_.push_back({static_cast<std::size_t>(&r - receives_.data()), first, std::min(r.count, first + kPart)});
        requests_->receives.emplace_back();
        check_mpi(MPI_Recv_init(r.buffer.data(), static_cast<int>(r.buffer.size()), MPI_DOUBLE, r.rank, kHaloTag, mpi, &requests_->receives.back()), "MPI_Recv_init");
    }
}

void Halo::send(int k, const Subdomain& sub) {
    Send& s = sends_[k];
    {
        // The message of the step before has long been taken; its buffer is free once MPI says so.
        const std::lock_guard lock(requests_->guard);
        check_mpi(MPI_Wait(&requests_->sends[k], MPI_STATUS_IGNORE), "MPI_Wait");
    }
    double* out = s.buffer.data();
    for (const LocalIndex i : s.grains) {
        std::memcpy(out, &sub.particles[i], kGhostDoubles * sizeof(double));
        out += kGhostDoubles;
    }
    for (const int t : s.tiles) {
        std::memcpy(out, &sub.tiles[static_cast<std::size_t>(t)].displacement, sizeof(DisplacementBox));
        out += kBoxDoubles;
    }
    const std::lock_guard lock(requests_->guard);
    check_mpi(MPI_Start(&requests_->sends[k]), "MPI_Start");
    sending_ = true;
}

void Halo::start_receives() {
    const std::lock_guard lock(requests_->guard);
    if (receives_.empty()) return;
    check_mpi(MPI_Startall(static_cast<int>(requests_->receives.size()), requests_->receives.data()), "MPI_Startall");
    receiving_ = true;
}

bool Halo::arrived() {
    const std::unique_lock lock(requests_->guard, std::try_to_lock);
    if (!lock) return false;
    if (sending_) sending_ = !test_all(requests_->sends);
    if (receiving_) receiving_ = !test_all(requests_->receives);
    return !receiving_;
}

int Halo::n_parts() const { return static_cast<int>(parts_.size()); }

void Halo::take(int part, Subdomain& sub) {
    const Part& p = parts_[static_cast<std::size_t>(part)];
    const Receive& r = receives_[p.receive];
    for (std::uint32_t k = p.first; k < p.end; ++k)
        std::memcpy(&sub.particles[sub.n_owned + r.first + k], r.buffer.data() + std::size_t{k} * kGhostDoubles, kGhostDoubles * sizeof(double));
    if (p.end < r.count) return;
    const double* boxes = r.buffer.data() + std::size_t{r.count} * kGhostDoubles;
    for (std::uint32_t c = 0; c < r.n_chunks; ++c, boxes += kBoxDoubles)
        std::memcpy(static_cast<void*>(&sub.chunk_displacement[static_cast<std::size_t>(r.first_chunk) + c]), boxes, sizeof(DisplacementBox));
}

void Halo::refresh(Subdomain& sub) {
    if (comm_.size() == 1) return;
    start_receives();
    for (int k = 0; k < n_neighbours(); ++k) send(k, sub);
    drain();
    for (int p = 0; p < n_parts(); ++p) take(p, sub);
}

void Halo::drain() {
    if (comm_.size() == 1) return;
    const std::lock_guard lock(requests_->guard);
    check_mpi(MPI_Waitall(static_cast<int>(requests_->sends.size()), requests_->sends.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
    check_mpi(MPI_Waitall(static_cast<int>(requests_->receives.size()), requests_->receives.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
    receiving_ = sending_ = false;
}

std::int64_t Halo::bytes_per_step() const {
    std::int64_t b = 0;
    for (const Send& s : sends_) b += static_cast<std::int64_t>(s.buffer.size() * sizeof(double));
    return b;
}

} // namespace talus::runtime
