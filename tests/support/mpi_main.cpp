// The main of the MPI tests. Every rank runs the same tests; a failure on any of them fails the test on all. Rank 0 prints the usual
// report, the others only their failures. A rank that fell out of a test (an exception) would leave the others waiting inside
// the engine: whoever waits too long at the end of a test for the others ends the job.
#include <gtest/gtest.h>
#include <mpi.h>

#include <chrono>
#include <cstdio>
#include <thread>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

namespace {

constexpr std::chrono::seconds kPatience{60};

int world_rank() {
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return rank;
}

/// The number of ranks for which `failed` holds; ends the job if they do not all come.
int count_failed(bool failed, const char* where) {
    int mine = failed ? 1 : 0, all = 0;
    MPI_Request request;
    MPI_Iallreduce(&mine, &all, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD, &request);
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    for (int done = 0; !done;) {
        MPI_Test(&request, &done, MPI_STATUS_IGNORE);
        if (done) break;
        if (failed && std::chrono::steady_clock::now() > deadline) {
            std::fprintf(stderr, "rank %d failed in %s and the other ranks do not come: they wait for it elsewhere\n", world_rank(), where);
            MPI_Abort(MPI_COMM_WORLD, 1);
        }
        std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    return all;
}

class AgreeOnFailures : public testing::EmptyTestEventListener {
public:
    AgreeOnFailures(int rank, bool& failed) : rank_(rank), failed_(failed) {}

    void OnTestPartResult(const testing::TestPartResult& r) override {
        if (rank_ == 0 || !r.failed()) return;
        std::fprintf(stderr, "rank %d: %s:%d: %s\n", rank_, r.file_name() != nullptr ? r.file_name() : "?", r.line_number(), r.summary());
        std::fflush(stderr);
    }
    void OnTestEnd(const testing::TestInfo& info) override {
        const int n = count_failed(info.result()->Failed(), info.name());
        if (n > 0 && rank_ == 0) std::fprintf(stderr, "%s.%s failed on %d rank(s)\n", info.test_suite_name(), info.name(), n);
        failed_ = failed_ || n > 0;
    }

private:
    int rank_;
    bool& failed_;
};

} // namespace

int main(int argc, char** argv) {
    int level = 0;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &level);
    if (level < MPI_THREAD_SERIALIZED) {
        std::fprintf(stderr, "this MPI gives no MPI_THREAD_SERIALIZED\n");
        MPI_Finalize();
        return 77;
    }
    testing::InitGoogleTest(&argc, argv);
    const int rank = world_rank();
    bool failed = false;
    auto& listeners = testing::UnitTest::GetInstance()->listeners();
    if (rank != 0) delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new AgreeOnFailures(rank, failed));
    const int result = RUN_ALL_TESTS();
    const int n = count_failed(result != 0 || failed, "main");
#if defined(__SANITIZE_ADDRESS__)
    // Leaks are looked for while MPI's modules are loaded: at exit they are gone, and what they keep has no name any more.
    __lsan_do_leak_check();
#endif
    MPI_Finalize();
    return n > 0 ? 1 : 0;
}
