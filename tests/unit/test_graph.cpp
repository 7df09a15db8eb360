// processors: 2
// Workers and the task graph of a step: who works, and in which order nodes run.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <set>
#include <thread>

#include "core/candidate_pairs.hpp"
#include "runtime/graph/step_graph.hpp"
#include "runtime/graph/workers.hpp"

namespace talus::runtime {
namespace {

/// Tiles in a ring, each beside the next; every third sees ghosts.
std::vector<core::Tile> ring(int n, bool ghosts) {
    std::vector<core::Tile> tiles(static_cast<std::size_t>(n));
    for (int t = 0; t < n; ++t) {
        std::set<int> beside{(t + 1) % n, (t + n - 1) % n};
        beside.erase(t);
        tiles[static_cast<std::size_t>(t)].neighbours.assign(beside.begin(), beside.end());
        if (ghosts && t % 3 == 0) tiles[static_cast<std::size_t>(t)].ghost_chunks = {0};
    }
    return tiles;
}

constexpr int kParts = 3; // of the ghosts

GraphShape shape_of(const std::vector<core::Tile>& tiles, bool talks, std::vector<std::vector<int>> tiles_of_send) {
    GraphShape shape{talks, talks ? kParts : 0, {}, {}, std::move(tiles_of_send)};
    for (const core::Tile& t : tiles) {
        shape.neighbours.push_back(t.neighbours);
        shape.sees_ghosts.push_back(!t.ghost_chunks.empty());
    }
    return shape;
}

/// Counts firings per node and notes every breach of order.
struct Watch {
    std::vector<core::Tile> tiles;
    std::vector<std::vector<int>> tiles_of_send;
    std::vector<std::atomic<int>> force, integrate, send;
    std::atomic<int> parts{0}, taken{0}, polls{0}, polls_needed{0}, breaches{0};
    int firing = 0;

    Watch(std::vector<core::Tile> t, std::vector<std::vector<int>> sends) : tiles(std::move(t)), tiles_of_send(std::move(sends)), force(tiles.size()), integrate(tiles.size()), send(tiles_of_send.size()) {}
    void expect(bool in_order) { breaches += in_order ? 0 : 1; }
    GraphShape shape(bool talks) const { return shape_of(tiles, talks, tiles_of_send); }
    StepHooks hooks() {
        StepHooks h;
        h.force = [this](int t) {
            expect(force[static_cast<std::size_t>(t)]++ == firing);
            expect(integrate[static_cast<std::size_t>(t)] == firing);
            if (!tiles[static_cast<std::size_t>(t)].ghost_chunks.empty()) expect(taken == firing + 1);
        };
        h.integrate = [this](int t) {
            expect(force[static_cast<std::size_t>(t)] == firing + 1);
            for (const int u : tiles[static_cast<std::size_t>(t)].neighbours) expect(force[static_cast<std::size_t>(u)] == firing + 1);
            expect(integrate[static_cast<std::size_t>(t)]++ == firing);
        };
        h.send = [this](int k) {
            for (const int t : tiles_of_send[static_cast<std::size_t>(k)]) expect(integrate[static_cast<std::size_t>(t)] == firing + 1);
            expect(send[static_cast<std::size_t>(k)]++ == firing);
        };
        h.halo_arrived = [this] { return ++polls >= polls_needed; };
        h.halo_take = [this](int) { expect(parts++ / kParts == firing && taken == firing && polls >= polls_needed); };
        h.halo_taken = [this] { expect(taken++ == firing && parts == kParts * (firing + 1)); };
        return h;
    }
    void expect_all_fired(int times, bool talks) {
        EXPECT_EQ(breaches, 0);
        for (const auto& n : force) EXPECT_EQ(n, times);
        for (const auto& n : integrate) EXPECT_EQ(n, times);
        for (const auto& n : send) EXPECT_EQ(n, times);
        EXPECT_EQ(taken, talks ? times : 0);
        EXPECT_EQ(parts, talks ? kParts * times : 0);
    }
};

TEST(Graph, every_node_runs_once_a_firing_and_after_what_it_waits_for_over_a_thousand_firings) {
    for (const int threads : {1, 2, 3})
        for (const bool talks : {false, true}) {
            SCOPED_TRACE(std::to_string(threads) + (talks ? " threads, talking" : " threads"));
            Workers workers(threads);
            Watch watch(ring(13, talks), talks ? std::vector<std::vector<int>>{{0, 1, 2}, {7}, {12, 3}} : std::vector<std::vector<int>>{});
            StepGraph graph(workers, watch.shape(talks), watch.hooks());
            for (watch.firing = 0; watch.firing < 1000; ++watch.firing) {
                watch.polls = 0;
                watch.polls_needed = watch.firing % 4; // late messages are asked for again
                graph.fire();
                EXPECT_GE(watch.polls, talks ? std::max(1, watch.firing % 4) : 0);
            }
            watch.expect_all_fired(1000, talks);
        }
}

TEST(Graph, a_tile_in_a_grid_moves_after_the_forces_of_all_around_it_through_corners_and_wraps) {
    for (const auto& [extent, wrap] : {std::pair{std::array{3, 4, 5}, false}, {std::array{3, 4, 5}, true}, {std::array{2, 1, 4}, true}, {std::array{1, 2, 2}, false}, {std::array{1, 1, 1}, true}}) {
        SCOPED_TRACE(fmt::format("{} x {} x {}{}", extent[0], extent[1], extent[2], wrap ? ", wrapping" : ""));
        core::CellGrid grid;
        for (int a = 0; a < 3; ++a) {
            grid.tiles[a] = grid.cells[a] = extent[a];
            grid.wraps[a] = wrap;
        }
        const core::CellOrder order(grid);
        // By looking at every pair of tiles.
        const auto place = [&](int t) { return std::array{t / (extent[1] * extent[2]), t / extent[2] % extent[1], t % extent[2]}; };
        std::vector<core::Tile> tiles(static_cast<std::size_t>(grid.n_tiles()));
        for (int t = 0; t < grid.n_tiles(); ++t)
            for (int u = 0; u < grid.n_tiles(); ++u) {
                bool adjacent = t != u;
                for (int a = 0; a < 3; ++a) {
                    const int apart = std::abs(place(t)[a] - place(u)[a]);
                    adjacent = adjacent && (apart <= 1 || (wrap && apart == extent[a] - 1));
                }
                if (adjacent) tiles[static_cast<std::size_t>(t)].neighbours.push_back(u);
            }
        std::vector<core::Tile> linked(tiles.size());
        core::link_neighbours(order, linked);
        for (std::size_t t = 0; t < tiles.size(); ++t) EXPECT_EQ(linked[t].neighbours, tiles[t].neighbours);

        Workers workers(2);
        Watch watch(tiles, {});
        StepGraph graph(workers, shape_of(linked, false, {}), watch.hooks());
        for (watch.firing = 0; watch.firing < 300; ++watch.firing) graph.fire();
        watch.expect_all_fired(300, false);
    }
}

TEST(Graph, one_tile_two_tiles_and_no_tile_at_all_are_fired_too) {
    for (const int n : {0, 1, 2}) {
        Workers workers(2);
        Watch watch(n == 0 ? std::vector<core::Tile>{} : ring(n, true), {});
        StepGraph graph(workers, watch.shape(true), watch.hooks());
        for (watch.firing = 0; watch.firing < 100; ++watch.firing) graph.fire();
        watch.expect_all_fired(100, true);
    }
}

TEST(Graph, tiles_without_ghosts_work_while_the_halo_is_awaited_and_the_poll_lets_the_others_go) {
    for (const int threads : {1, 2}) {
        Workers workers(threads);
        const auto tiles = ring(6, true); // tiles 0 and 3 see ghosts
        std::atomic<int> inner{0}, outer{0}, outer_early{0};
        std::atomic<bool> arrived{false};
        StepHooks h;
        h.force = [&](int t) {
            if (tiles[static_cast<std::size_t>(t)].ghost_chunks.empty()) {
                ++inner;
            } else {
                outer_early += arrived ? 0 : 1;
                ++outer;
            }
        };
        h.integrate = [](int) {};
        h.send = [](int) {};
        // The message comes only after all inner tiles are done: if they waited for it, this would never end.
        h.halo_arrived = [&] { return inner == 4; };
        h.halo_take = [](int) {};
        h.halo_taken = [&] { arrived = true; };
        StepGraph graph(workers, shape_of(tiles, true, {}), h);
        for (int k = 0; k < 200; ++k) {
            inner = 0;
            outer = 0;
            arrived = false;
            graph.fire();
            ASSERT_EQ(inner, 4);
            ASSERT_EQ(outer, 2);
        }
        EXPECT_EQ(outer_early, 0);
    }
}

TEST(Graph, as_many_workers_as_asked_for_are_seen_even_beyond_the_processors) {
    for (const int threads : {1, 2, 3}) {
        Workers workers(threads);
        EXPECT_EQ(workers.threads(), threads);
        EXPECT_EQ(workers.observed(), 0);
        // Bodies that wait for each other need as many threads as there are bodies.
        std::atomic<int> here{0};
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        workers.for_each(Phase::force, threads, [&](int) {
            ++here;
            while (here < threads && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
        });
        EXPECT_EQ(here, threads);
        EXPECT_EQ(workers.observed(), threads);
        EXPECT_EQ(workers.total(Phase::force).calls, threads);
        EXPECT_GT(workers.busy(), 0.0);
    }
}

TEST(Graph, for_each_runs_every_item_once_on_an_index_below_the_number_of_threads) {
    Workers workers(3);
    std::vector<std::atomic<int>> times(1000);
    std::atomic<int> bad{0};
    workers.for_each(Phase::binning, 1000, [&](int i) {
        ++times[static_cast<std::size_t>(i)];
        bad += Workers::current() < 0 || Workers::current() >= 3 ? 1 : 0;
    });
    for (const auto& t : times) EXPECT_EQ(t, 1);
    EXPECT_EQ(bad, 0);
}

TEST(Graph, a_trace_holds_every_event_between_start_and_stop_and_nothing_else) {
    Workers workers(2);
    const auto ten = [&] { workers.for_each(Phase::integrate, 10, [](int) {}); };
    ten();
    workers.start_trace();
    ten();
    const std::string trace = workers.stop_trace(4);
    ten();
    std::size_t events = 0;
    for (std::size_t at = 0; (at = trace.find("\"ph\":\"X\"", at)) != std::string::npos; ++at) ++events;
    EXPECT_EQ(events, 10u);
    EXPECT_NE(trace.find("\"pid\":4"), std::string::npos);
    EXPECT_NE(trace.find("\"integrate\""), std::string::npos);
    workers.start_trace();
    EXPECT_EQ(workers.stop_trace(0).find("\"ph\":\"X\""), std::string::npos);
}

} // namespace
} // namespace talus::runtime
