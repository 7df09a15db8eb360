// apps/bench/benchmarks.hpp: what Google Benchmark is told to run.
#pragma once

#include "apps/bench/scene.hpp"

namespace talus::bench {

void add_benchmarks(const SceneOptions& options);

} // namespace talus::bench
