// talus-bench: what a step costs, and where it goes.
//
//   talus-bench [SCENE OPTIONS] [Google Benchmark's own options]   phases one by one, in every law and width
//   talus-bench --table [--scene NAME] [--law NAME] [--steps N] [--warm N] [--json FILE] [SCENE OPTIONS]
//       time, bytes, flops and roofs of each phase of a scene as it runs, and what the task graph costs
//   talus-bench --balance --bed FILE [--whole] [--step F] [--halo M] [--of N] [--json FILE]
//       the load balancer alone, for thousands of ranks, on the bed's cost field repeated to billions of grains
//   talus-bench --write-bed FILE [--scene NAME] [SCENE OPTIONS]    a scene's grains, for other codes
//
// Scene options: [--bed FILE] [--axes xzy] [--grains N] [--threads T] [--skin M].
#include <benchmark/benchmark.h>

#include <CLI/CLI.hpp>

#include "apps/bench/balance_study.hpp"
#include "apps/bench/benchmarks.hpp"
#include "apps/bench/grains.hpp"
#include "apps/bench/laws.hpp"
#include "apps/bench/table.hpp"
#include "apps/sandbox/process_memory.hpp"

namespace {

using namespace talus::bench;

struct Options {
    SceneOptions scene;
    TableOptions table;
    std::string name = "bed", law = "default", write, json;
    bool wants_table = false, wants_balance = false;
    BalanceOptions balance;
};

Scene make_scene(const Options& o) {
    if (o.name == "chute") return make_chute(o.scene);
    if (o.name == "gas") return make_gas(o.scene);
    return make_bed(o.scene, std::find_if(std::begin(kLaws), std::end(kLaws), [&](const NamedLaws& l) { return l.name == o.law; })->laws());
}

void add_options(CLI::App& app, Options& o) {
    std::vector<std::string> laws;
    for (const NamedLaws& l : kLaws) laws.emplace_back(l.name);
    auto* bed = app.add_option("--bed", o.scene.bed, "bed file, text or HDF5; without it a bed is settled first")->check(CLI::ExistingFile);
    app.add_option("--axes", o.scene.axes, "which axes of the file are our x, y (up), z")->capture_default_str()->check(CLI::IsMember({"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"}));
    app.add_option("--grains", o.scene.grains, "grains of scenes that are not of a file; 0: 20,000 of a bed, 50,000 of the others")->capture_default_str()->check(CLI::NonNegativeNumber);
    app.add_option("--threads", o.scene.threads, "worker threads")->capture_default_str()->check(CLI::PositiveNumber);
    app.add_option("--skin", o.scene.skin, "list skin [m]; 0 chooses")->capture_default_str()->check(CLI::NonNegativeNumber);
    auto* table = app.add_flag("--table", o.wants_table, "phases of a scene as it runs, with bytes, flops and what the machine could do");
    auto* write = app.add_option("--write-bed", o.write, "write a scene's grains, with velocities, to a bed file")->excludes(table);
    auto* balance = app.add_flag("--balance", o.wants_balance, "the balancer alone, at 64, 1024 and 16,384 subdomains")->excludes(table)->excludes(write)->needs(bed);
    app.add_flag("--whole", o.balance.whole, "of --balance: stretch the bed along x, do not repeat it there")->needs(balance);
    app.add_option("--step", o.balance.step, "of --balance: how much dearer the grains of one part are")->capture_default_str()->check(CLI::PositiveNumber)->needs(balance);
    app.add_option("--halo", o.balance.reach, "of --balance: also with cuts held to this way a rebalance [m]")->check(CLI::PositiveNumber)->needs(balance);
    app.add_option("--of", o.balance.grains, "of --balance: number of grains")->capture_default_str()->check(CLI::PositiveNumber)->needs(balance);
    app.add_option("--scene", o.name, "of --table and --write-bed: bed, chute or gas")->capture_default_str()->check(CLI::IsMember({"bed", "chute", "gas"}));
    app.add_option("--law", o.law, "of the bed")->capture_default_str()->check(CLI::IsMember(laws));
    app.add_option("--steps", o.table.steps, "of --table, timed")->capture_default_str()->check(CLI::PositiveNumber)->needs(table);
    app.add_option("--warm", o.table.warm, "of --table, before them")->capture_default_str()->check(CLI::NonNegativeNumber)->needs(table);
    auto* json = app.add_option("--json", o.json, "of --table and --balance: write the figures there");
    app.callback([&o, bed, table, write, balance, json] {
        if (json->count() > 0 && table->count() + balance->count() == 0) throw CLI::ValidationError("--json", "belongs to --table or --balance; benchmarks have --benchmark_out");
        const bool one_scene = table->count() + write->count() > 0;
        if (o.name != "bed" && !one_scene) throw CLI::ValidationError("--scene", "belongs to --table or --write-bed; benchmarks are chosen by --benchmark_filter");
        if (o.name != "bed" && bed->count() > 0) throw CLI::ValidationError("--bed", "is a file of the scene bed, not of " + o.name);
    });
    app.allow_extras();
}

/// @return false if the remaining arguments are not Google Benchmark's
bool start_benchmark(const CLI::App& app, char* program) {
    std::vector<std::string> rest = app.remaining();
    std::vector<char*> arguments{program};
    for (std::string& r : rest) arguments.push_back(r.data());
    int count = static_cast<int>(arguments.size());
    benchmark::Initialize(&count, arguments.data());
    return !benchmark::ReportUnrecognizedArguments(count, arguments.data());
}

} // namespace

int main(int argc, char** argv) {
    talus::keep_large_blocks_apart();
    Options o;
    CLI::App app{"What a step of Talus costs; further options go to Google Benchmark (--benchmark_filter=..., --benchmark_format=json)."};
    add_options(app, o);
    CLI11_PARSE(app, argc, argv);
    if (!start_benchmark(app, argv[0])) return 2;
    try {
        if (o.wants_balance) {
            o.balance.json = o.json;
            study_balance(read_bed(o.scene), o.balance);
        } else if (!o.write.empty()) {
            const Scene scene = make_scene(o);
            write_bed(o.write, o.scene.axes, scene.lo, scene.hi, gather(scene.engine.get()));
        } else if (o.wants_table) {
            o.table.resident_before = talus::resident_bytes();
            Scene scene = make_scene(o);
            const Table table = measure(scene, o.name, o.table);
            print(table);
            if (!o.json.empty()) write_json(table, o.json);
        } else {
            add_benchmarks(o.scene);
            benchmark::RunSpecifiedBenchmarks();
        }
    } catch (const std::exception& e) {
        std::fprintf(stderr, "talus-bench: %s\n", e.what());
        return 1;
    }
    return 0;
}
