// talus-bench: what a phase costs.
//
//   talus-bench [--bed FILE --axes xzy] [--grains N] [--threads T] [--skin M] [Google Benchmark's own options]
//   talus-bench --write-bed FILE --scene NAME [--axes xzy] ...
#include <benchmark/benchmark.h>

#include <CLI/CLI.hpp>

#include "apps/bench/benchmarks.hpp"
#include "apps/bench/grains.hpp"
#include "apps/bench/laws.hpp"

int main(int argc, char** argv) {
    using namespace talus::bench;
    SceneOptions options;
    std::string scene = "bed", write;
    CLI::App app{"Phase timings of Talus; further options go to Google Benchmark (--benchmark_filter=..., --benchmark_format=json)."};
    app.add_option("--scene", scene, "what --write-bed takes: bed, chute or gas")->check(CLI::IsMember({"bed", "chute", "gas"}))->capture_default_str();
    app.add_option("--bed", options.bed, "bed file, text or HDF5; without it a bed is settled first")->check(CLI::ExistingFile);
    app.add_option("--axes", options.axes, "which axes of the file are our x, y (up), z")->capture_default_str();
    app.add_option("--grains", options.grains, "grains of scenes that are not of a file; 0: 20,000 of a bed, 50,000 of the others")->capture_default_str();
    app.add_option("--threads", options.threads, "worker threads")->capture_default_str()->check(CLI::PositiveNumber);
    app.add_option("--skin", options.skin, "list skin [m]; 0 chooses")->capture_default_str();
    app.add_option("--write-bed", write, "write the scene's grains to a bed file");
    app.allow_extras();
    CLI11_PARSE(app, argc, argv);

    std::vector<std::string> rest = app.remaining();
    std::vector<char*> arguments{argv[0]};
    for (std::string& r : rest) arguments.push_back(r.data());
    int count = static_cast<int>(arguments.size());
    benchmark::Initialize(&count, arguments.data());
    if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
    try {
        if (!write.empty()) {
            const Scene s = scene == "gas" ? make_gas(options) : scene == "chute" ? make_chute(options) : make_bed(options, kLaws[0].laws());
            write_bed(write, options.axes, s.lo, s.hi, gather(s.engine.get()));
            return 0;
        }
        add_benchmarks(options);
        benchmark::RunSpecifiedBenchmarks();
    } catch (const std::exception& e) {
        std::fprintf(stderr, "talus-bench: %s\n", e.what());
        return 1;
    }
    return 0;
}
