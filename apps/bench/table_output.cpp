#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/bench/table.hpp"

namespace talus::bench {

namespace {

double ratio(double a, double b) { return b > 0.0 ? a / b : 0.0; }

/// Bytes a second of a phase as it ran, on all threads at once.
double bandwidth(const Table& t, const PhaseRow& r) { return ratio(r.bytes * t.threads, r.busy); }

/// The force on grains by grains, a contact, part by part; the last part is what was counted beyond all others.
std::vector<LawOperations::Part> force_parts(const Table& t) {
    std::vector<LawOperations::Part> parts;
    const double a_contact = ratio(t.end_pairs.searched, t.end_pairs.contacts);
    parts.push_back({fmt::format("filter, {:.2f} candidates", a_contact), t.law.candidate.scaled(a_contact)});
    parts.insert(parts.end(), t.law.parts.begin(), t.law.parts.end());
    Operations rest = t.force.pairs.scaled(ratio(1.0, t.end_pairs.contacts));
    for (const auto& p : parts) rest += p.operations.scaled(-1.0);
    parts.push_back({"caps, integers, sums", rest});
    return parts;
}

nlohmann::json json_of(const Operations& o) {
    return {{"add", o.add}, {"multiply", o.multiply}, {"fused", o.fused}, {"divide", o.divide}, {"root", o.root}, {"other", o.other}, {"flops", o.flops()}};
}

} // namespace

void print(const Table& t) {
    using fmt::print;
    print("{}: {:.0f} grains, {} thread{}, {} steps, {} rebuilds (one every {:.1f} steps), skin {:.4g} mm\n", t.scene, t.particles, t.threads, t.threads == 1 ? "" : "s", t.steps, t.rebuilds,
          ratio(static_cast<double>(t.steps), static_cast<double>(t.rebuilds)), 1e3 * t.skin);
    print("{:.2f} million particle-steps/s; a grain has {:.2f} contacts with grains, {:.3f} with walls, {:.2f} candidates; mean velocity {:.3g} {:.3g} {:.3g} m/s\n\n", t.particle_steps() / t.wall / 1e6,
          t.contacts / t.particles, t.wall_contacts / t.particles, t.candidates / t.particles, t.velocity[0], t.velocity[1], t.velocity[2]);

    print("a particle-step  | busy ns | share  | bytes  | GB/s   | of triad | flops  | Gflop/s\n");
    const double whole = t.wall * t.threads / t.particle_steps();
    for (const PhaseRow& r : t.phases) {
        const auto cell = [](bool is, double value, int digits) { return is ? fmt::format("{:.{}f}", value, digits) : std::string("-"); };
        print("{:<16} | {:>7.2f} | {:>5.1f}% | {:>6} | {:>6} | {:>8} | {:>6} | {:>7}\n", r.name, 1e9 * r.busy, 100.0 * r.busy / whole, cell(r.bytes > 0.0, r.bytes, 0),
              cell(r.bytes > 0.0, 1e-9 * bandwidth(t, r), 2), cell(r.bytes > 0.0, bandwidth(t, r) / t.roofs.triad.all, 2), cell(r.flops > 0.0, r.flops, 0),
              cell(r.flops > 0.0, 1e-9 * ratio(r.flops * t.threads, r.busy), 2));
    }
    print("{:<16} | {:>7.2f} | {:>5.1f}% |\n\n", "no phase", 1e9 * whole * t.idle, 100.0 * t.idle);
    print("triad: {:.1f} GB/s with one thread, {:.1f} with {}; four divisions take {:.2f} ns, four roots {:.2f}\n", 1e-9 * t.roofs.triad.one, 1e-9 * t.roofs.triad.all, t.threads, 1e9 * t.roofs.divide, 1e9 * t.roofs.root);
    print("processor: had for {:.0f} % of {} x step time; less than all where others use the machine, or workers sleep\n", 100.0 * t.processor, t.threads);
    print("graph: {:.1f} % of {} x step time is in no phase (waiting, scheduling, what one thread does between firings); {} nodes with nothing in them: {:.1f} us a firing, {:.1f} % of a step\n",
          100.0 * t.idle, t.threads, t.nodes, 1e6 * t.empty_firing, 100.0 * t.empty_firing * static_cast<double>(t.steps) / t.wall);
    print("force: {:.1f} ns a contact in the steps; where grains stand at the end {:.1f} in the graph, {:.1f} in a plain loop over tiles; divisions and roots alone need {:.1f}, {:.0f} % of the loop\n\n",
          1e9 * t.force_in_steps, 1e9 * t.force_in_graph, 1e9 * t.force_in_loop, 1e9 * t.divider_bound(), 100.0 * ratio(t.divider_bound(), t.force_in_loop));

    const auto a_grain = [&](double bytes) { return bytes / t.particles; };
    print("memory, bytes a grain: {:.0f} at most while stepping, {:.0f} at the end (of the process, beyond what it had at its start); of the engine: records {:.0f}, cells {:.0f}, sums {:.0f}, pairs {:.0f}, histories {:.0f}, for the next rebuild {:.0f}\n\n",
          a_grain(t.peak), a_grain(t.resident), a_grain(static_cast<double>(t.memory.records)), a_grain(static_cast<double>(t.memory.cells)), a_grain(static_cast<double>(t.memory.sums)),
          a_grain(static_cast<double>(t.memory.pairs)), a_grain(static_cast<double>(t.memory.histories)), a_grain(static_cast<double>(t.memory.rebuild)));

    print("a contact of grains      |    add |    mul |    fma |   div |  sqrt |  flops\n");
    Operations sum;
    const auto line = [](const std::string& name, const Operations& o) {
        print("{:<24} | {:>6.1f} | {:>6.1f} | {:>6.1f} | {:>5.1f} | {:>5.1f} | {:>6.1f}\n", name, o.add, o.multiply, o.fused, o.divide, o.root, o.flops());
    };
    for (const auto& p : force_parts(t)) {
        line(p.name, p.operations);
        sum += p.operations;
    }
    line("all", sum);
    print("\nBytes: a model, each array that a phase works on once (apps/bench/traffic.hpp); above the triad where the scene fits in cache.\n"
          "Flops: counted by running the kernel on numbers that count (counted.hpp), fma as two; of integrate by hand.\n");
}

void write_json(const Table& t, const std::string& path) {
    nlohmann::json j{{"scene", t.scene}, {"build", t.build}, {"threads", t.threads}, {"steps", t.steps}, {"rebuilds", t.rebuilds}, {"particles", t.particles}, {"skin", t.skin}};
    j["laws"] = {{"normal", static_cast<int>(t.laws.normal)}, {"damping", static_cast<int>(t.laws.damping)},
                 {"tangential", static_cast<int>(t.laws.tangential)}, {"rolling", static_cast<int>(t.laws.rolling)}};
    j["seconds"] = t.wall;
    j["particle_steps_per_second"] = t.particle_steps() / t.wall;
    j["bytes_per_particle"] = static_cast<double>(t.memory.total()) / t.particles; // as a run's summary.json has it
    j["memory"] = {{"peak", t.peak}, {"resident", t.resident}, {"records", t.memory.records}, {"cells", t.memory.cells}, {"sums", t.memory.sums},
                   {"pairs", t.memory.pairs}, {"histories", t.memory.histories}, {"rebuild", t.memory.rebuild}};
    j["candidates"] = t.candidates;
    j["contacts"] = t.contacts;
    j["wall_contacts"] = t.wall_contacts;
    j["idle"] = t.idle;
    j["processor"] = t.processor;
    j["empty_firing"] = t.empty_firing;
    j["nodes"] = t.nodes;
    j["force_a_contact"] = {{"in_steps", t.force_in_steps}, {"in_graph", t.force_in_graph}, {"in_loop", t.force_in_loop}, {"divider_bound", t.divider_bound()}};
    j["roofs"] = {{"triad_one_thread", t.roofs.triad.one}, {"triad", t.roofs.triad.all}, {"divide_four", t.roofs.divide}, {"root_four", t.roofs.root}};
    j["end"] = {{"kinetic_energy", t.kinetic_energy}, {"mean_height", t.mean_height}, {"contacts_per_grain", t.contacts_per_particle}, {"velocity", t.velocity}};
    for (const PhaseRow& r : t.phases)
        j["phases"].push_back({{"name", r.name}, {"busy", r.busy}, {"bytes", r.bytes}, {"flops", r.flops}, {"bytes_per_second", bandwidth(t, r)},
                               {"of_triad", ratio(bandwidth(t, r), t.roofs.triad.all)}});
    for (const auto& p : force_parts(t)) j["force_parts"].push_back({{"name", p.name}, {"operations", json_of(p.operations)}});
    std::ofstream file(path);
    file << j.dump(1) << "\n";
    file.close();
    if (!file) core::fail(core::ErrorKind::io, "{}: could not be written", path);
}

} // namespace talus::bench
