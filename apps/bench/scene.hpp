// apps/bench/scene.hpp: the bed that is measured: of a file, or settled on the spot.
#pragma once

#include <memory>
#include <string>

#include "capi/src/guard.hpp"
#include "talus.h"

namespace talus::bench {

struct SceneOptions {
    std::string bed;           // file of the driver's formats; empty: settle one
    std::string axes = "xyz";  // of the file, e.g. xzy when z is up there
    std::int64_t grains = 20000;
    int threads = 1;
    double skin = 0.0;
};

struct EngineDeleter {
    void operator()(talus_engine* e) const { talus_engine_destroy(e); }
};
using EnginePtr = std::unique_ptr<talus_engine, EngineDeleter>;

/// Throw core::Error with the library's message when a call failed.
void check(talus_status status, const talus_engine* engine);

/// A bed of sand between walls under gravity (the material of Table 1 of the paper), the wall at low x moving in at 0.1 m/s,
/// after some steps of shear.
EnginePtr make_bed(const SceneOptions& options, const talus_laws& laws);

} // namespace talus::bench
