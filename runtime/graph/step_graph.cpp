#include "runtime/graph/step_graph.hpp"

#include <deque>
#include <thread>

#include <tbb/flow_graph.h>

#include "runtime/graph/happens_before.hpp"

namespace talus::runtime {

namespace flow = tbb::flow;

struct StepGraph::Nodes {
    using Node = flow::continue_node<flow::continue_msg>;
    using Join = flow::continue_node<flow::continue_msg, flow::lightweight>; // runs where its last predecessor did

    Nodes(Workers& w, StepHooks h) : workers(w), hooks(std::move(h)) {}

    Workers& workers;
    StepHooks hooks;
    // The graph takes the arena it is made in, so it is made inside ours.
    std::unique_ptr<flow::graph> graph;
    std::unique_ptr<flow::broadcast_node<flow::continue_msg>> start;
    std::unique_ptr<flow::function_node<flow::continue_msg>> poll;
    std::unique_ptr<flow::broadcast_node<flow::continue_msg>> arrived;
    std::unique_ptr<Join> ghosts; // all parts of them are written
    std::vector<std::unique_ptr<Node>> take, force, integrate, send;
    std::vector<std::unique_ptr<Join>> joins;
    Milestone fired, messages_here, ghosts_written;
    std::vector<Milestone> taken, forces_done, integrated, sent;
    std::deque<std::vector<Milestone>> joined; // along each axis but the last

    /// What a compute node does. `before` are the milestones of its predecessors: one for every edge.
    struct Task {
        Nodes& nodes;
        Phase phase;
        int item;
        std::function<void(int)>& body;
        std::vector<Milestone*> before;
        Milestone& mine;
        bool of_tile;
        Milestone made;

        void run() {
            made.after();
            for (Milestone* m : before) m->after();
            const double seconds = nodes.workers.timed(phase, item, [&] { body(item); });
            if (of_tile && nodes.hooks.worked) nodes.hooks.worked(item, seconds);
            mine.done();
        }
    };
    std::vector<std::unique_ptr<Task>> tasks;

    /// What nodes of one kind, one a tile, hand on.
    struct Layer {
        std::vector<flow::sender<flow::continue_msg>*> nodes;
        std::vector<Milestone>* done;
    };
    /// The predecessors of tile t in a layer: its own node, and those beside it.
    static std::vector<std::size_t> among(std::size_t t, const std::vector<int>& beside) {
        std::vector<std::size_t> all{t};
        all.insert(all.end(), beside.begin(), beside.end());
        return all;
    }
    static std::vector<Milestone*> milestones(const Layer& layer, const std::vector<std::size_t>& tiles) {
        std::vector<Milestone*> all;
        for (const std::size_t u : tiles) all.push_back(&(*layer.done)[u]);
        return all;
    }
    /// A layer that joins what is beside along an axis.
    Layer join(const Layer& layer, const std::vector<std::vector<int>>& beside) {
        Layer next{{}, &joined.emplace_back(layer.nodes.size())};
        for (std::size_t t = 0; t < layer.nodes.size(); ++t) {
            const auto from = among(t, beside[t]);
            auto body = [before = milestones(layer, from), mine = &(*next.done)[t]](flow::continue_msg) noexcept TALUS_TASK_BODY { pass_on(before, *mine); };
            Join* node = joins.emplace_back(std::make_unique<Join>(*graph, std::move(body))).get();
            for (const std::size_t u : from) flow::make_edge(*layer.nodes[u], *node);
            next.nodes.push_back(node);
        }
        return next;
    }
    static void pass_on(const std::vector<Milestone*>& before, Milestone& mine) {
        for (Milestone* m : before) m->after();
        mine.done();
    }

    void all_taken() {
        messages_here.after();
        for (Milestone& part : taken) part.after();
        hooks.halo_taken();
        ghosts_written.done();
    }
    void poll_once() {
        fired.after();
        if (hooks.halo_arrived()) {
            messages_here.done();
            arrived->try_put(flow::continue_msg{});
            return;
        }
        // Nothing there: let another process or worker have the processor, then queue up again behind all compute nodes.
        std::this_thread::yield();
        poll->try_put(flow::continue_msg{});
    }
};

StepGraph::StepGraph(Workers& workers, GraphShape shape, StepHooks hooks) : shape_(std::move(shape)), nodes_(std::make_unique<Nodes>(workers, std::move(hooks))) {
    Nodes& n = *nodes_;
    const bool talks = shape_.talks;
    const auto& tiles_of_send = shape_.tiles_of_send;
    const std::size_t n_tiles = shape_.tiles;
    workers.arena().execute([&] {
        n.graph = std::make_unique<flow::graph>();
        n.start = std::make_unique<flow::broadcast_node<flow::continue_msg>>(*n.graph);
        // Priorities cost a little in the scheduler; without messages there is nothing to go before.
        const flow::node_priority_t priority = talks ? 1 : flow::no_priority;
        const auto node = [&](Phase phase, int item, std::function<void(int)>& body, std::vector<Milestone*> before, Milestone& mine) {
            Nodes::Task* task = n.tasks.emplace_back(new Nodes::Task{n, phase, item, body, std::move(before), mine, phase != Phase::halo_exchange, {}}).get();
            task->made.done();
            return std::make_unique<Nodes::Node>(*n.graph, [task](flow::continue_msg) TALUS_TASK_BODY { task->run(); }, priority);
        };
        n.forces_done.resize(n_tiles);
        n.integrated.resize(n_tiles);
        n.sent.resize(tiles_of_send.size());
        if (talks) {
            n.poll = std::make_unique<flow::function_node<flow::continue_msg>>(*n.graph, flow::unlimited, [&n](flow::continue_msg) TALUS_TASK_BODY { n.poll_once(); });
            n.arrived = std::make_unique<flow::broadcast_node<flow::continue_msg>>(*n.graph);
            flow::make_edge(*n.start, *n.poll);
            n.taken.resize(static_cast<std::size_t>(shape_.parts));
            n.ghosts = std::make_unique<Nodes::Join>(*n.graph, [&n](flow::continue_msg) noexcept TALUS_TASK_BODY { n.all_taken(); });
            flow::make_edge(*n.arrived, *n.ghosts);
            for (int p = 0; p < shape_.parts; ++p) {
                n.take.push_back(node(Phase::halo_exchange, p, n.hooks.halo_take, {&n.messages_here}, n.taken[static_cast<std::size_t>(p)]));
                flow::make_edge(*n.arrived, *n.take.back());
                flow::make_edge(*n.take.back(), *n.ghosts);
            }
        }
        for (std::size_t t = 0; t < n_tiles; ++t) {
            const bool waits = talks && shape_.sees_ghosts[t];
            n.force.push_back(node(Phase::force, static_cast<int>(t), n.hooks.force, {waits ? &n.ghosts_written : &n.fired}, n.forces_done[t]));
            flow::make_edge(waits ? static_cast<flow::sender<flow::continue_msg>&>(*n.ghosts) : *n.start, *n.force.back());
        }
        Nodes::Layer layer{{}, &n.forces_done};
        for (const auto& f : n.force) layer.nodes.push_back(f.get());
        std::vector<std::vector<int>> beside(n_tiles);
        bool first = true;
        for (const auto& axis : shape_.beside) {
            if (axis.empty()) continue;
            if (!first) layer = n.join(layer, beside);
            beside = axis;
            first = false;
        }
        for (std::size_t t = 0; t < n_tiles; ++t) {
            const auto from = Nodes::among(t, beside[t]);
            n.integrate.push_back(node(Phase::integrate, static_cast<int>(t), n.hooks.integrate, Nodes::milestones(layer, from), n.integrated[t]));
            for (const std::size_t u : from) flow::make_edge(*layer.nodes[u], *n.integrate[t]);
        }
        for (std::size_t k = 0; k < tiles_of_send.size(); ++k) {
            std::vector<Milestone*> before;
            for (const int t : tiles_of_send[k]) before.push_back(&n.integrated[static_cast<std::size_t>(t)]);
            n.send.push_back(node(Phase::halo_exchange, static_cast<int>(k), n.hooks.send, std::move(before), n.sent[k]));
            for (const int t : tiles_of_send[k]) flow::make_edge(*n.integrate[static_cast<std::size_t>(t)], *n.send.back());
        }
    });
}

StepGraph::~StepGraph() {
    if (nodes_->graph) nodes_->workers.arena().execute([&] { nodes_->graph->wait_for_all(); });
}

void StepGraph::fire() {
    Nodes& n = *nodes_;
    n.fired.done();
    n.workers.arena().execute([&] {
        n.start->try_put(flow::continue_msg{});
        n.graph->wait_for_all();
    });
    n.ghosts_written.after();
    for (auto* milestones : {&n.forces_done, &n.integrated, &n.sent})
        for (Milestone& m : *milestones) m.after();
}

} // namespace talus::runtime
