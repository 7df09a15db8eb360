// runtime/graph/step_graph.hpp: the task graph of a step. With workers.hpp the only place that knows TBB.
//
// One firing of the graph goes from the positions of a step to the positions of the next:
//
//     start ─┬─────────────────────────────────► force(t) for tiles without ghosts ─┐
//            └─► halo_exchange: look ──► take(p) ──► force(t) for tiles with ghosts ┴─► integrate(t) ──► halo_exchange: send(k)
//
//   force(t)      writes the sums and histories of tile t only (border rows stand for grains of other tiles)
//   integrate(t)  waits for force of t and of the tiles around it, collects their border rows, kicks, drifts
//   send(k)       waits for the tiles that neighbour k sees; the message is taken in the next firing
//   look          tests for arrivals: at the start, after every eighth force, and, when all tiles without ghosts are done, again and
//                 again; it holds no worker while there are tiles to work on
//   take(p)       writes a part of the ghosts when all messages are there; after all of them the next receives are posted, and the
//                 tiles that see ghosts let go
//
// So no barrier stands between force and integrate, and a tile's message leaves as soon as its grains have moved. Between
// firings one thread decides what is global (rebuild, stop, errors).
//
// Order     edges run only between neighbouring tiles; the graph is built once per decomposition and fired every step. What waits for
//           dozens of tiles waits on a count of them in four bytes; as edges of TBB they are a list each, and cold in every step
// First     a worker takes what came last. So tiles beside those with ghosts are put last, ghosts that arrive go before all others, and
//           a neighbour's message leaves early in the step
// MPI       called by look and the send nodes, one at a time (a lock in Halo): MPI_THREAD_SERIALIZED
// Errors    a body never throws into TBB: it stores the first error; later compute bodies return at once, but messages are
//           still sent and taken, so no neighbour waits for ever
// Lifetime  nodes refer to the graph's hooks; wait() returns before anything is destroyed
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "runtime/graph/workers.hpp"

namespace talus::runtime {

/// What the nodes do. All of them may run on any worker; none may throw.
struct StepHooks {
    std::function<void(int tile)> force;
    std::function<void(int tile)> integrate;
    std::function<void(int tile, double seconds)> worked; // what one of these two took; may be empty
    std::function<void(int neighbour)> send;
    std::function<bool()> halo_arrived; // true when nothing is awaited any more; asked now and then by several workers, also after that
    std::function<void(int part)> halo_take; // write a part of the ghosts
    std::function<void()> halo_taken;   // all parts are written: post the next receives
};

/// What the nodes and edges follow from. A rebuild that leaves it as it was keeps its graph.
struct GraphShape {
    bool talks = false;                          // whether this rank has neighbours at all
    int parts = 0;                               // of the ghosts that are written on their own
    std::vector<std::vector<int>> neighbours;    // of each tile, itself excluded
    std::vector<bool> sees_ghosts;               // each tile
    std::vector<std::vector<int>> tiles_of_send; // the tiles whose grains each neighbour sees

    bool operator==(const GraphShape&) const = default;
};

class StepGraph {
public:
    StepGraph(Workers& workers, GraphShape shape, StepHooks hooks);
    ~StepGraph();
    const GraphShape& shape() const { return shape_; }

    /// Run every node once. Blocks until all are done.
    void fire();

private:
    struct Nodes;
    GraphShape shape_;
    std::unique_ptr<Nodes> nodes_;
};

} // namespace talus::runtime
