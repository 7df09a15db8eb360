// runtime/comm/communicator.hpp: the engine's own communicator, serial or MPI. With comm/halo.cpp the only face of MPI.
//
// Threads  calls are serialised by the caller (the step graph funnels them); MPI_THREAD_SERIALIZED suffices.
// Errors   ERRORS_RETURN on the duplicate only; a failing call throws ErrorKind::comm on the ranks that see it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/fixed_sum.hpp"

namespace talus::runtime {

using Bytes = std::vector<std::byte>;

/// A message to or from a rank.
struct Parcel {
    int rank;
    Bytes data;
};

class Communicator {
public:
    /// A communicator of one; no MPI call is ever made.
    Communicator();
    /// Duplicates the communicator behind a Fortran handle. [collective]
    explicit Communicator(std::int32_t comm_f);
    ~Communicator();
    Communicator(const Communicator&) = delete;
    Communicator& operator=(const Communicator&) = delete;

    int rank() const { return rank_; }
    int size() const { return size_; }

    // All of the following are collective.
    void barrier();
    void broadcast(void* data, std::size_t bytes, int root);
    std::string broadcast(const std::string& text, int root);
    double max(double v);
    double min(double v);
    std::int64_t max(std::int64_t v);
    std::int64_t sum(std::int64_t v);
    std::uint64_t sum_modulo(std::uint64_t v); // modulo 2^64
    void sum(std::vector<std::int64_t>& v);
    void max(std::vector<double>& v);
    void sum(core::Wide* v, int n);
    /// Messages to any ranks, at most one parcel to each, without an all-to-all (NBX, Hoefler et al. 2010); parcels come back sorted
    /// by rank. A parcel to oneself is delivered too. @param most_bytes  of one MPI message; longer parcels go in several
    std::vector<Parcel> sparse_exchange(std::vector<Parcel> outgoing, std::size_t most_bytes = std::size_t{1} << 30);
    /// Gather bytes of every rank on rank 0, in rank order; empty elsewhere.
    std::vector<Bytes> gather(const Bytes& mine);

    /// So many bytes of every rank, in rank order, on all of them. @param all  [size() * bytes]
    void gather_all(const void* mine, std::size_t bytes, void* all);

    /// A non-blocking max-reduction of doubles, one at a time: start, then finish (which waits). Numbers only.
    void start_max(std::vector<double> v);
    std::vector<double> finish_max();

    struct Handle; // wraps MPI_Comm
    const Handle* handle() const { return handle_.get(); }

private:
    std::unique_ptr<Handle> handle_;
    int rank_ = 0, size_ = 1;
    std::vector<double> pending_in_, pending_out_;
    int exchange_tag_ = 0;
};

} // namespace talus::runtime
