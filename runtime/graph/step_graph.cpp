#include "runtime/graph/step_graph.hpp"

#include <atomic>
#include <thread>

#include <tbb/flow_graph.h>

#include "runtime/graph/happens_before.hpp"

namespace talus::runtime {

namespace flow = tbb::flow;

namespace {

constexpr int kForcesBetweenLooks = 8; // a call into MPI that finds nothing takes some microseconds, a tile a hundred

using Node = flow::continue_node<flow::continue_msg>;

/// Lets the last of so many go on, once a firing.
class Countdown {
public:
    void add() { left_.store(++all_, std::memory_order_relaxed); }
    bool waits() const { return all_ > 0; }
    /// @return true for the last, who sees what the others did. The next firing begins anew.
    bool down() {
        if (left_.fetch_sub(1, std::memory_order_acq_rel) != 1) return false;
        left_.store(all_, std::memory_order_relaxed);
        ready_.done();
        return true;
    }
    /// What the last one lets go comes after it.
    Milestone& ready() { return ready_; }

private:
    std::atomic<int> left_{0};
    int all_ = 0;
    Milestone ready_;
};

/// Who counts down on what, of many, one after the other in memory.
class Lists {
public:
    explicit Lists(const std::vector<std::vector<int>>& lists = {}) {
        for (const auto& list : lists) {
            items_.insert(items_.end(), list.begin(), list.end());
            first_.push_back(items_.size());
        }
    }
    template <class Body>
    void for_each(int k, Body body) const {
        for (std::size_t at = first_[static_cast<std::size_t>(k)]; at < first_[static_cast<std::size_t>(k) + 1]; ++at) body(static_cast<std::size_t>(items_[at]));
    }

private:
    std::vector<std::size_t> first_{0};
    std::vector<int> items_;
};

/// @param lists  of each of some, which of n others are in it
/// @return of each of the others, in whose lists it is
std::vector<std::vector<int>> turned(const std::vector<std::vector<int>>& lists, std::size_t n) {
    std::vector<std::vector<int>> of(n);
    for (std::size_t k = 0; k < lists.size(); ++k)
        for (const int item : lists[k]) of[static_cast<std::size_t>(item)].push_back(static_cast<int>(k));
    return of;
}

} // namespace

struct StepGraph::Nodes {
    Nodes(Workers& w, StepHooks h, const GraphShape& s)
        : workers(w), hooks(std::move(h)), shape(s), neighbours(s.neighbours), sends_of_tile(turned(s.tiles_of_send, s.neighbours.size())), forces_left(s.neighbours.size()), moves_left(s.tiles_of_send.size()),
          forces_done(s.neighbours.size()), taken(static_cast<std::size_t>(s.parts)), done(s.neighbours.size() + s.tiles_of_send.size()) {}

    Workers& workers;
    StepHooks hooks;
    const GraphShape& shape;
    // The graph takes the arena it is made in, so it is made inside ours.
    std::unique_ptr<flow::graph> graph;
    std::unique_ptr<flow::broadcast_node<flow::continue_msg>> start, arrived;
    std::unique_ptr<Node> poll;
    std::unique_ptr<flow::continue_node<flow::continue_msg, flow::lightweight>> ghosts; // all parts of them are written
    std::vector<std::unique_ptr<Node>> take, force, integrate, send;

    Lists neighbours, sends_of_tile;
    std::vector<Countdown> forces_left, moves_left; // that integrate(t) and send(k) wait for
    Countdown without_ghosts_left;                  // forces that need no message
    std::atomic<bool> messages_taken{false};        // somebody has seen that they are all there
    Milestone fired, messages_here, ghosts_written;
    std::vector<Milestone> forces_done, taken, done; // done: of integrate and send

    /// What a node does that is timed as a phase: first what it comes after, last what it lets go.
    struct Task {
        Nodes& nodes;
        Phase phase;
        int item;
        std::function<void(int)>& body;
        Milestone& before;
        Milestone& mine;
        void (Nodes::*then)(int); // may be null
        Milestone made;

        void run() {
            made.after();
            before.after();
            const double seconds = nodes.workers.timed(phase, item, [&] { body(item); });
            if (phase != Phase::halo_exchange && nodes.hooks.worked) nodes.hooks.worked(item, seconds);
            mine.done();
            if (then != nullptr) (nodes.*then)(item);
        }
    };
    std::vector<std::unique_ptr<Task>> tasks;

    static void go(Node& node) { node.try_put(flow::continue_msg{}); }

    void after_force(int t) {
        // The poll goes below what this tile lets go.
        if (shape.talks && !shape.sees_ghosts[static_cast<std::size_t>(t)] && without_ghosts_left.down()) go(*poll);
        const auto down = [this](std::size_t u) {
            if (forces_left[u].down()) go(*integrate[u]);
        };
        neighbours.for_each(t, down);
        down(static_cast<std::size_t>(t));
        if (shape.talks && t % kForcesBetweenLooks == 0) look();
    }
    void after_integrate(int t) {
        sends_of_tile.for_each(t, [this](std::size_t k) {
            if (moves_left[k].down()) go(*send[k]);
        });
    }

    /// @return true when the messages are there, whoever saw it
    bool look() {
        if (!hooks.halo_arrived()) return messages_taken;
        if (messages_taken.exchange(true)) return true;
        messages_here.done();
        arrived->try_put(flow::continue_msg{});
        return true;
    }
    void poll_once() {
        without_ghosts_left.ready().after();
        fired.after();
        if (look()) return;
        // Nothing there: let another process have the processor.
        std::this_thread::yield();
        go(*poll);
    }
    void all_taken() {
        messages_here.after();
        for (Milestone& part : taken) part.after();
        hooks.halo_taken();
        ghosts_written.done();
    }

    std::unique_ptr<Node> make(Phase phase, int item, std::function<void(int)>& body, Milestone& before, Milestone& mine, void (Nodes::*then)(int)) {
        Task* task = tasks.emplace_back(new Task{*this, phase, item, body, before, mine, then, {}}).get();
        task->made.done();
        return std::make_unique<Node>(*graph, [task](flow::continue_msg) TALUS_TASK_BODY { task->run(); });
    }
    void make_all();
};

void StepGraph::Nodes::make_all() {
    const std::size_t n_tiles = shape.neighbours.size(), n_sends = shape.tiles_of_send.size();
    graph = std::make_unique<flow::graph>();
    start = std::make_unique<flow::broadcast_node<flow::continue_msg>>(*graph);
    if (shape.talks) {
        poll = std::make_unique<Node>(*graph, [this](flow::continue_msg) TALUS_TASK_BODY { poll_once(); });
        arrived = std::make_unique<flow::broadcast_node<flow::continue_msg>>(*graph);
        ghosts = std::make_unique<flow::continue_node<flow::continue_msg, flow::lightweight>>(*graph, [this](flow::continue_msg) noexcept TALUS_TASK_BODY { all_taken(); });
        flow::make_edge(*arrived, *ghosts);
        for (int p = 0; p < shape.parts; ++p) {
            take.push_back(make(Phase::halo_exchange, p, hooks.halo_take, messages_here, taken[static_cast<std::size_t>(p)], nullptr));
            flow::make_edge(*arrived, *take.back());
            flow::make_edge(*take.back(), *ghosts);
        }
    }
    const auto waits = [&](std::size_t t) { return shape.talks && shape.sees_ghosts[t]; };
    std::vector<std::size_t> far, near;
    for (std::size_t t = 0; t < n_tiles; ++t) {
        force.push_back(make(Phase::force, static_cast<int>(t), hooks.force, waits(t) ? ghosts_written : fired, forces_done[t], &Nodes::after_force));
        integrate.push_back(make(Phase::integrate, static_cast<int>(t), hooks.integrate, forces_left[t].ready(), done[t], &Nodes::after_integrate));
        bool beside_ghosts = false;
        forces_left[t].add();
        for (const int u : shape.neighbours[t]) {
            forces_left[t].add();
            beside_ghosts = beside_ghosts || waits(static_cast<std::size_t>(u));
        }
        if (waits(t)) {
            flow::make_edge(*ghosts, *force[t]);
        } else {
            (beside_ghosts ? near : far).push_back(t);
            without_ghosts_left.add();
        }
    }
    for (const auto* tiles : {&far, &near})
        for (const std::size_t t : *tiles) flow::make_edge(*start, *force[t]);
    for (std::size_t k = 0; k < n_sends; ++k) {
        send.push_back(make(Phase::halo_exchange, static_cast<int>(k), hooks.send, moves_left[k].ready(), done[n_tiles + k], nullptr));
        for (std::size_t n = 0; n < shape.tiles_of_send[k].size(); ++n) moves_left[k].add();
    }
}

StepGraph::StepGraph(Workers& workers, GraphShape shape, StepHooks hooks) : shape_(std::move(shape)), nodes_(std::make_unique<Nodes>(workers, std::move(hooks), shape_)) {
    workers.arena().execute([&] { nodes_->make_all(); });
}

StepGraph::~StepGraph() {
    if (nodes_->graph) nodes_->workers.arena().execute([&] { nodes_->graph->wait_for_all(); });
}

void StepGraph::fire() {
    Nodes& n = *nodes_;
    n.messages_taken = false;
    n.fired.done();
    n.workers.arena().execute([&] {
        n.start->try_put(flow::continue_msg{});
        if (shape_.talks) {
            if (!n.without_ghosts_left.waits())
                Nodes::go(*n.poll);
            else
                n.look();
        }
        n.graph->wait_for_all();
    });
    n.ghosts_written.after();
    for (auto* milestones : {&n.forces_done, &n.done})
        for (Milestone& m : *milestones) m.after();
}

} // namespace talus::runtime
