// team.hpp: the ranks of this run as the driver sees them. Rank 0 reads, writes and prints; what it finds is agreed
// here, so that either all ranks go on or all throw the same Failure. Every function is collective unless said.
#ifndef TALUS_SANDBOX_TEAM_HPP
#define TALUS_SANDBOX_TEAM_HPP

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>

#include "failure.hpp"

namespace talus::sandbox {

class Team {
public:
    // Duplicates the communicator, so that no message of the driver can meet one of the engine. [collective]
    explicit Team(MPI_Comm comm);
    ~Team();
    Team(const Team&) = delete;
    Team& operator=(const Team&) = delete;

    int rank() const { return rank_; }
    int size() const { return size_; }
    int size_on_node() const { return size_on_node_; } // ranks that share this machine's memory
    bool is_root() const { return rank_ == 0; }
    MPI_Comm comm() const { return comm_; }

    // Run `work` on rank 0 only. A Failure or any other exception there becomes the same Failure on every rank.
    void on_root(const std::function<void()>& work) const;
    // Rank 0's value, everywhere.
    std::int64_t from_root(std::int64_t value) const;
    double from_root(double value) const;
    std::string from_root(const std::string& value) const;
    std::int64_t largest(std::int64_t value) const;
    std::int64_t smallest(std::int64_t value) const;

private:
    MPI_Comm comm_ = MPI_COMM_NULL;
    int rank_ = 0;
    int size_ = 1;
    int size_on_node_ = 1;
};

} // namespace talus::sandbox

#endif
