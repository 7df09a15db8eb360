// apps/bench/table.hpp: where the time of a scene goes, beside what the machine could do.
#pragma once

#include <string>
#include <vector>

#include "apps/bench/flops.hpp"
#include "apps/bench/lists.hpp"
#include "apps/bench/machine.hpp"
#include "apps/bench/scene.hpp"
#include "apps/bench/traffic.hpp"

namespace talus::bench {

struct TableOptions {
    std::int64_t warm = 20, steps = 500;
    double resident_before = 0.0; // bytes of the process before the scene was made
};

struct PhaseRow {
    std::string name;
    double busy = 0.0;  // s, over all workers, a particle-step
    double bytes = 0.0; // a particle-step, by the model of traffic.hpp
    double flops = 0.0; // a particle-step; counted, for integrate by hand
};

struct Roofs {
    Triad triad{};                   // bytes/s
    double divide = 0.0, root = 0.0; // s, of four lanes
};

struct Table {
    std::string scene, build;
    core::Laws laws;
    int threads = 1;
    std::int64_t steps = 0, rebuilds = 0;
    double particles = 0.0;
    double wall = 0.0; // s, of all steps
    double skin = 0.0; // m
    runtime::Subdomain::Bytes memory;  // held by the engine at the end
    double resident = 0.0, peak = 0.0; // bytes of the process beyond those at its start: at the end, and at most during the steps
    double candidates = 0.0, contacts = 0.0, wall_contacts = 0.0; // mean over the steps
    std::vector<PhaseRow> phases;
    // Share of the workers' time in which no phase ran: waiting (spinning too), scheduling, and what one thread does between firings.
    double idle = 0.0;
    // Share of the workers' time that the system gave this process a processor for: below one where others use the machine, or workers sleep.
    double processor = 0.0;
    double empty_firing = 0.0; // s: the same graph with nothing in its nodes
    int nodes = 0;
    // s a contact: busy in the steps; and at their end where grains stand, in the graph and by one worker in a plain loop over tiles.
    double force_in_steps = 0.0, force_in_graph = 0.0, force_in_loop = 0.0;
    LawOperations law;
    ForceOperations force;           // at the end of the steps,
    ListCounts end_pairs, end_walls; // with these lists
    Roofs roofs;
    // End state, for comparing with others.
    double kinetic_energy = 0.0, mean_height = 0.0, contacts_per_particle = 0.0; // J of translation; m; each contact for both grains
    std::array<double, 3> velocity{};

    double end_contacts() const { return end_pairs.contacts + end_walls.contacts; }
    double particle_steps() const { return particles * static_cast<double>(steps); }
    /// Least time of a contact if nothing but divisions and roots took any [s].
    double divider_bound() const;
};

/// Step a scene and measure. The engine is left as the last step left it, but that contact histories have gone on where grains stood.
Table measure(Scene& scene, const std::string& name, const TableOptions& options);

void print(const Table& table);
void write_json(const Table& table, const std::string& path);

} // namespace talus::bench
