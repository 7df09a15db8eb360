// runtime/graph/step_graph.hpp: the task graph of a step. With workers.hpp the only place that knows TBB.
//
// One firing of the graph goes from the positions of a step to the positions of the next:
//
//     start ─┬─────────────────────────────────► force(t) for tiles without ghosts ─┐
//            └─► halo_exchange: poll ──► take(p) ──► force(t) for tiles with ghosts ┴─► integrate(t) ──► halo_exchange: send(k)
//
//   force(t)      writes the sums and histories of tile t only (border rows stand for grains of other tiles)
//   integrate(t)  waits for force of t and of the tiles around it, collects their border rows, kicks, drifts. It waits along one axis
//                 after the other: for three joins of three joins of three forces, nine edges a tile in place of 27
//   send(k)       waits for the tiles that neighbour k sees; the message is taken in the next firing
//   poll          tests for arrivals and puts itself back behind other work; never holds a worker
//   take(p)       writes a part of the ghosts when all messages are there; after all of them the next receives are posted, and the
//                 tiles that see ghosts let go
//
// So no barrier stands between force and integrate, and a tile's message leaves as soon as its grains have moved. Between
// firings one thread decides what is global (rebuild, stop, errors).
//
// Order     edges run only between neighbouring tiles; the graph is built once per decomposition and fired every step
// Priority  compute nodes go before the poll, so a worker tests requests only between tiles or when nothing else is left
// MPI       called by the poll and the send nodes, one at a time (a lock in Halo): MPI_THREAD_SERIALIZED
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
    std::function<bool()> halo_arrived; // true when nothing is awaited any more
    std::function<void(int part)> halo_take; // write a part of the ghosts
    std::function<void()> halo_taken;   // all parts are written: post the next receives
};

/// What the nodes and edges follow from. A rebuild that leaves it as it was keeps its graph.
struct GraphShape {
    bool talks = false;                          // whether this rank has neighbours at all
    int parts = 0;                               // of the ghosts that are written on their own
    std::size_t tiles = 0;
    // The tiles beside each along an axis. Neighbours are those that one step or none along every axis leads to; an axis along which no
    // tile has another is empty.
    std::vector<std::vector<int>> beside[3];
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
