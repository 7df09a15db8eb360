#include "team.hpp"

#include <new>

namespace talus::sandbox {

Team::Team(MPI_Comm comm) {
    MPI_Comm_dup(comm, &comm_);
    MPI_Comm_rank(comm_, &rank_);
    MPI_Comm_size(comm_, &size_);
    MPI_Comm node = MPI_COMM_NULL;
    MPI_Comm_split_type(comm_, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &node);
    MPI_Comm_size(node, &size_on_node_);
    MPI_Comm_free(&node);
}

Team::~Team() { MPI_Comm_free(&comm_); }

void Team::on_root(const std::function<void()>& work) const {
    std::int64_t code = kExitDone;
    std::string text;
    if (is_root()) {
        try {
            work();
        } catch (const Failure& failure) {
            code = failure.code();
            text = failure.what();
        } catch (const std::bad_alloc&) {
            code = kExitInternal;
            text = "out of memory";
        } catch (const std::exception& error) {
            code = kExitInternal;
            text = error.what();
        }
    }
    code = from_root(code);
    if (code != kExitDone) throw Failure(static_cast<ExitCode>(code), from_root(text));
}

std::int64_t Team::from_root(std::int64_t value) const {
    MPI_Bcast(&value, 1, MPI_INT64_T, 0, comm_);
    return value;
}

double Team::from_root(double value) const {
    MPI_Bcast(&value, 1, MPI_DOUBLE, 0, comm_);
    return value;
}

std::string Team::from_root(const std::string& value) const {
    std::string copy = value;
    copy.resize(static_cast<std::size_t>(from_root(static_cast<std::int64_t>(value.size()))));
    MPI_Bcast(copy.data(), static_cast<int>(copy.size()), MPI_CHAR, 0, comm_);
    return copy;
}

std::int64_t Team::largest(std::int64_t value) const {
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_INT64_T, MPI_MAX, comm_);
    return value;
}

std::int64_t Team::smallest(std::int64_t value) const {
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_INT64_T, MPI_MIN, comm_);
    return value;
}

} // namespace talus::sandbox
