#include "runtime/comm/communicator.hpp"

#include <algorithm>
#include <cstring>

#include "runtime/comm/mpi_handle.hpp"

namespace talus::runtime {

using core::ErrorKind;
using core::fail;

Communicator::Communicator() = default;

Communicator::Communicator(std::int32_t comm_f) {
    int initialised = 0, finalised = 0;
    MPI_Initialized(&initialised);
    MPI_Finalized(&finalised);
    if (!initialised || finalised) fail(ErrorKind::state, "MPI is {}: an engine over a communicator needs it between MPI_Init and MPI_Finalize; use the serial constructor without MPI", finalised ? "finalised" : "not initialised");
    int level = 0;
    MPI_Query_thread(&level);
    if (level < MPI_THREAD_SERIALIZED) fail(ErrorKind::state, "MPI was initialised with thread level {}; Talus calls it from worker threads, one at a time: use MPI_Init_thread with MPI_THREAD_SERIALIZED", level == MPI_THREAD_SINGLE ? "MPI_THREAD_SINGLE" : "MPI_THREAD_FUNNELED");
    const MPI_Comm parent = MPI_Comm_f2c(static_cast<MPI_Fint>(comm_f));
    if (parent == MPI_COMM_NULL) fail(ErrorKind::argument, "the communicator handle {} is MPI_COMM_NULL", comm_f);
    handle_ = std::make_unique<Handle>();
    check_mpi(MPI_Comm_dup(parent, &handle_->comm), "MPI_Comm_dup");
    MPI_Comm_set_errhandler(handle_->comm, MPI_ERRORS_RETURN);
    MPI_Comm_rank(handle_->comm, &rank_);
    MPI_Comm_size(handle_->comm, &size_);
}

Communicator::~Communicator() {
    if (!handle_) return;
    int finalised = 0;
    MPI_Finalized(&finalised);
    if (!finalised) MPI_Comm_free(&handle_->comm);
}

void Communicator::barrier() {
    if (size_ > 1) check_mpi(MPI_Barrier(handle_->comm), "MPI_Barrier");
}

void Communicator::broadcast(void* data, std::size_t bytes, int root) {
    if (size_ == 1) return;
    // Counts are ints: large blocks go in pieces.
    constexpr std::size_t kPiece = std::size_t{1} << 30;
    for (std::size_t at = 0; at < bytes; at += kPiece)
        check_mpi(MPI_Bcast(static_cast<char*>(data) + at, static_cast<int>(std::min(kPiece, bytes - at)), MPI_BYTE, root, handle_->comm), "MPI_Bcast");
}

std::string Communicator::broadcast(const std::string& text, int root) {
    std::uint64_t n = text.size();
    broadcast(&n, sizeof n, root);
    std::string out = rank_ == root ? text : std::string(n, ' ');
    broadcast(out.data(), n, root);
    return out;
}

namespace {
template <class T>
T reduce_one(const Communicator& c, T v, MPI_Datatype type, MPI_Op op) {
    if (c.size() > 1) check_mpi(MPI_Allreduce(MPI_IN_PLACE, &v, 1, type, op, c.handle()->comm), "MPI_Allreduce");
    return v;
}
} // namespace

double Communicator::max(double v) { return reduce_one(*this, v, MPI_DOUBLE, MPI_MAX); }
double Communicator::min(double v) { return reduce_one(*this, v, MPI_DOUBLE, MPI_MIN); }
std::int64_t Communicator::max(std::int64_t v) { return reduce_one(*this, v, MPI_INT64_T, MPI_MAX); }
std::int64_t Communicator::sum(std::int64_t v) { return reduce_one(*this, v, MPI_INT64_T, MPI_SUM); }
std::uint64_t Communicator::sum_modulo(std::uint64_t v) { return reduce_one(*this, v, MPI_UINT64_T, MPI_SUM); }

void Communicator::sum(std::vector<std::int64_t>& v) {
    if (size_ > 1 && !v.empty()) check_mpi(MPI_Allreduce(MPI_IN_PLACE, v.data(), static_cast<int>(v.size()), MPI_INT64_T, MPI_SUM, handle_->comm), "MPI_Allreduce");
}
void Communicator::max(std::vector<double>& v) {
    if (size_ > 1 && !v.empty()) check_mpi(MPI_Allreduce(MPI_IN_PLACE, v.data(), static_cast<int>(v.size()), MPI_DOUBLE, MPI_MAX, handle_->comm), "MPI_Allreduce");
}

void Communicator::sum(core::Wide* v, int n) {
    if (size_ == 1) return;
    // MPI has no 128-bit integers: sum the 32-bit digits (the top one signed) and carry afterwards.
    std::vector<std::int64_t> digits;
    for (int k = 0; k < n; ++k)
        for (int d = 0; d < 4; ++d) digits.push_back(d < 3 ? static_cast<std::int64_t>(static_cast<std::uint32_t>(v[k] >> (32 * d))) : static_cast<std::int64_t>(v[k] >> 96));
    sum(digits);
    for (int k = 0; k < n; ++k) {
        v[k] = 0;
        for (int d = 0; d < 4; ++d) v[k] += static_cast<core::Wide>(digits[4 * k + d]) * (static_cast<core::Wide>(1) << (32 * d));
    }
}

std::vector<Parcel> Communicator::sparse_exchange(std::vector<Parcel> outgoing, std::size_t most_bytes) {
    std::vector<Parcel> incoming;
    for (Parcel& p : outgoing)
        if (p.rank == rank_) incoming.push_back({rank_, std::move(p.data)});
    if (size_ > 1) {
        // Two tags in turn: a rank that is already in the next exchange cannot be taken for one of this.
        const int tag = kExchangeTag + exchange_tag_;
        exchange_tag_ ^= 1;
        std::vector<MPI_Request> sends;
        for (const Parcel& p : outgoing) {
            if (p.rank == rank_) continue;
            for (std::size_t at = 0; at == 0 || at < p.data.size(); at += most_bytes) {
                sends.emplace_back();
                check_mpi(MPI_Issend(p.data.data() + at, static_cast<int>(std::min(most_bytes, p.data.size() - at)), MPI_BYTE, p.rank, tag, handle_->comm, &sends.back()), "MPI_Issend");
            }
        }
        MPI_Request barrier = MPI_REQUEST_NULL;
        bool in_barrier = false;
        for (int done = 0; !done;) {
            int arrived = 0;
            MPI_Status status;
            check_mpi(MPI_Iprobe(MPI_ANY_SOURCE, tag, handle_->comm, &arrived, &status), "MPI_Iprobe");
            if (arrived) {
                int n = 0;
                MPI_Get_count(&status, MPI_BYTE, &n);
                // Pieces of one parcel come in order.
                const auto begun = std::find_if(incoming.begin(), incoming.end(), [&](const Parcel& p) { return p.rank == status.MPI_SOURCE; });
                Parcel& p = begun != incoming.end() ? *begun : incoming.emplace_back(Parcel{status.MPI_SOURCE, {}});
                const std::size_t at = p.data.size();
                p.data.resize(at + static_cast<std::size_t>(n));
                check_mpi(MPI_Recv(p.data.data() + at, n, MPI_BYTE, p.rank, tag, handle_->comm, MPI_STATUS_IGNORE), "MPI_Recv");
            }
            if (!in_barrier) {
                int sent = 0;
                check_mpi(MPI_Testall(static_cast<int>(sends.size()), sends.data(), &sent, MPI_STATUSES_IGNORE), "MPI_Testall");
                if (sent) {
                    check_mpi(MPI_Ibarrier(handle_->comm, &barrier), "MPI_Ibarrier");
                    in_barrier = true;
                }
            } else {
                check_mpi(MPI_Test(&barrier, &done, MPI_STATUS_IGNORE), "MPI_Test");
            }
        }
    }
    std::sort(incoming.begin(), incoming.end(), [](const Parcel& a, const Parcel& b) { return a.rank < b.rank; });
    return incoming;
}

std::vector<Bytes> Communicator::gather(const Bytes& mine) {
    std::vector<Parcel> out;
    out.push_back({0, mine});
    std::vector<Bytes> all;
    for (Parcel& p : sparse_exchange(std::move(out))) all.push_back(std::move(p.data));
    return all;
}

void Communicator::gather_all(const void* mine, std::size_t bytes, void* all) {
    if (size_ == 1)
        std::memcpy(all, mine, bytes);
    else
        check_mpi(MPI_Allgather(mine, static_cast<int>(bytes), MPI_BYTE, all, static_cast<int>(bytes), MPI_BYTE, handle_->comm), "MPI_Allgather");
}

void Communicator::start_max(std::vector<double> v) {
    pending_in_ = std::move(v);
    pending_out_ = pending_in_;
    if (size_ > 1)
        check_mpi(MPI_Iallreduce(pending_in_.data(), pending_out_.data(), static_cast<int>(pending_in_.size()), MPI_DOUBLE, MPI_MAX, handle_->comm, &handle_->reduction), "MPI_Iallreduce");
}

std::vector<double> Communicator::finish_max() {
    if (size_ > 1) check_mpi(MPI_Wait(&handle_->reduction, MPI_STATUS_IGNORE), "MPI_Wait");
    return pending_out_;
}

} // namespace talus::runtime
