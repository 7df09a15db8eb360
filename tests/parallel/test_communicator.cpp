// ranks: 1 2 3 4
// Messages to whom it may concern, in whatever pieces.
#include <numeric>

#include "../support/determinism.hpp"
#include "runtime/comm/communicator.hpp"

namespace talus::runtime {
namespace {

/// What rank `from` sends rank `to` in a round: nothing to some; the length and every byte tell who, to whom and when.
Bytes message(int from, int to, int round) {
    test::Random random(static_cast<std::uint64_t>(from * 1000 + to * 10 + round));
    const double size = random.uniform(-1000.0, 3000.0);
    Bytes b(size > 0.0 ? static_cast<std::size_t>(size) : 0);
    for (std::byte& x : b) x = static_cast<std::byte>(random.uniform(0.0, 256.0));
    return b;
}

TEST(Communicator, parcels_arrive_whole_sorted_by_rank_and_in_the_round_they_belong_to) {
    Communicator comm(test::world_handle());
    for (const std::size_t most : {std::size_t{1} << 30, std::size_t{100}, std::size_t{1}})
        for (int round = 0; round < 5; ++round) {
            std::vector<Parcel> out;
            for (int to = 0; to < comm.size(); ++to)
                if (Bytes b = message(comm.rank(), to, round); !b.empty()) out.push_back({to, std::move(b)});
            const std::vector<Parcel> in = comm.sparse_exchange(std::move(out), most);
            std::size_t next = 0;
            for (int from = 0; from < comm.size(); ++from) {
                const Bytes expected = message(from, comm.rank(), round);
                if (expected.empty()) continue;
                ASSERT_LT(next, in.size());
                EXPECT_EQ(in[next].rank, from);
                EXPECT_TRUE(in[next].data == expected) << "from " << from << ", pieces of " << most;
                ++next;
            }
            EXPECT_EQ(next, in.size());
        }
}

TEST(Communicator, an_empty_parcel_arrives_too) {
    Communicator comm(test::world_handle());
    const int to = (comm.rank() + 1) % comm.size();
    const auto in = comm.sparse_exchange({{to, {}}});
    ASSERT_EQ(in.size(), 1u);
    EXPECT_EQ(in[0].rank, (comm.rank() + comm.size() - 1) % comm.size());
    EXPECT_TRUE(in[0].data.empty());
}

TEST(Communicator, gathered_bytes_stand_in_rank_order_on_all) {
    Communicator comm(test::world_handle());
    const std::int64_t mine = 100 + comm.rank();
    std::vector<std::int64_t> all(static_cast<std::size_t>(comm.size())), expected(all.size());
    std::iota(expected.begin(), expected.end(), 100);
    comm.gather_all(&mine, sizeof mine, all.data());
    EXPECT_EQ(all, expected);
}

} // namespace
} // namespace talus::runtime
