#include "runtime/graph/step_graph.hpp"

#include <thread>

#include <tbb/flow_graph.h>

namespace talus::runtime {

namespace flow = tbb::flow;

struct StepGraph::Nodes {
    using Node = flow::continue_node<flow::continue_msg>;

    Nodes(Workers& w, StepHooks h) : workers(w), hooks(std::move(h)) {}

    Workers& workers;
    StepHooks hooks;
    // The graph takes the arena it is made in, so it is made inside ours.
    std::unique_ptr<flow::graph> graph;
    std::unique_ptr<flow::broadcast_node<flow::continue_msg>> start;
    std::unique_ptr<flow::function_node<flow::continue_msg>> poll;
    std::unique_ptr<flow::broadcast_node<flow::continue_msg>> arrived;
    std::vector<std::unique_ptr<Node>> force, integrate, send;

    void poll_once() {
        if (hooks.halo_arrived()) {
            workers.timed(Phase::halo_exchange, 0, [&] { hooks.halo_take(); });
            arrived->try_put(flow::continue_msg{});
            return;
        }
        // Nothing there: let another process or worker have the processor, then queue up again behind all compute nodes.
        std::this_thread::yield();
        poll->try_put(flow::continue_msg{});
    }
};

StepGraph::StepGraph(Workers& workers, const std::vector<core::Tile>& tiles, bool talks, const std::vector<std::vector<int>>& tiles_of_send, StepHooks hooks)
    : nodes_(std::make_unique<Nodes>(workers, std::move(hooks))) {
    Nodes& n = *nodes_;
    workers.arena().execute([&] {
        n.graph = std::make_unique<flow::graph>();
        n.start = std::make_unique<flow::broadcast_node<flow::continue_msg>>(*n.graph);
        // Priorities cost a little in the scheduler; without messages there is nothing to go before.
        const flow::node_priority_t priority = talks ? 1 : flow::no_priority;
        const auto node = [&](Phase phase, int item, std::function<void(int)>& body) {
            return std::make_unique<Nodes::Node>(
                *n.graph, [&n, phase, item, &body](flow::continue_msg) { n.workers.timed(phase, item, [&] { body(item); }); }, priority);
        };
        if (talks) {
            n.poll = std::make_unique<flow::function_node<flow::continue_msg>>(*n.graph, flow::unlimited, [&n](flow::continue_msg) { n.poll_once(); });
            n.arrived = std::make_unique<flow::broadcast_node<flow::continue_msg>>(*n.graph);
            flow::make_edge(*n.start, *n.poll);
        }
        for (std::size_t t = 0; t < tiles.size(); ++t) {
            n.force.push_back(node(Phase::force, static_cast<int>(t), n.hooks.force));
            n.integrate.push_back(node(Phase::integrate, static_cast<int>(t), n.hooks.integrate));
            flow::make_edge(talks && !tiles[t].ghost_chunks.empty() ? *n.arrived : *n.start, *n.force.back());
        }
        for (std::size_t t = 0; t < tiles.size(); ++t) {
            flow::make_edge(*n.force[t], *n.integrate[t]);
            for (const int u : tiles[t].neighbours) flow::make_edge(*n.force[t], *n.integrate[u]);
        }
        for (std::size_t k = 0; k < tiles_of_send.size(); ++k) {
            n.send.push_back(node(Phase::halo_exchange, static_cast<int>(k), n.hooks.send));
            for (const int t : tiles_of_send[k]) flow::make_edge(*n.integrate[t], *n.send.back());
        }
    });
}

StepGraph::~StepGraph() {
    if (nodes_->graph) nodes_->workers.arena().execute([&] { nodes_->graph->wait_for_all(); });
}

void StepGraph::fire() {
    nodes_->workers.arena().execute([&] {
        nodes_->start->try_put(flow::continue_msg{});
        nodes_->graph->wait_for_all();
    });
}

} // namespace talus::runtime
