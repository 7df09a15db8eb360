// apps/bench/scene.hpp: the scenes that are measured, through the C ABI.
//   bed     sand between walls, the front one moving in: of a file, or settled on the spot. Contacts last, lists do too
//   chute   a layer flowing down a rough incline, periodic in x and z: linear law with tangential history. Contacts come and go
//   gas     loose grains of solid fraction 0.3 in the bed's box, falling and colliding: rebuilds are most of the work
#pragma once

#include <array>
#include <memory>
#include <string>

#include "apps/sandbox/bed_file.hpp"
#include "capi/src/guard.hpp"
#include "talus.h"

namespace talus::bench {

struct SceneOptions {
    std::string bed;           // file of the driver's formats, for the bed; empty: settle one
    std::string axes = "xyz";  // of the file, e.g. xzy when z is up there
    std::int64_t grains = 0;   // about so many; 0: 20,000 of the bed, 50,000 of the others
    int threads = 1;
    double skin = 0.0;         // m; 0: the engine's default
};

struct EngineDeleter {
    void operator()(talus_engine* e) const { talus_engine_destroy(e); }
};
using EnginePtr = std::unique_ptr<talus_engine, EngineDeleter>;

struct Scene {
    EnginePtr engine;
    std::array<double, 3> lo{}, hi{}; // m: between walls, and periods
};

/// Throw core::Error with the library's message when a call failed.
void check(talus_status status, const talus_engine* engine);

// Grains of all scenes that are not of a file: those of the comparison with peers.
inline constexpr double kRadiusMin = 1.02375e-3, kRadiusMax = 1.25125e-3; // m, uniform
inline constexpr double kYoung = 1e7, kPoisson = 0.2, kDensity = 2600.0;
inline constexpr double kGravity = 9.81;
/// Groups of grains.
inline constexpr std::int32_t kFree = 0, kFrozen = 1;

/// The file of the options.
sandbox::Bed read_bed(const SceneOptions& options);

/// The wall at low x moves in at 0.1 m/s; returned after some steps of shear. Material of Table 1 of the paper.
Scene make_bed(const SceneOptions& options, const talus_laws& laws);

/// After Silbert et al. (2001), "Granular flow down an inclined plane: Bagnold scaling and rheology", Phys. Rev. E 64, 051302:
/// stiffness 2e5 m g/d, tangential 2/7 of it, undamped; restitution 0.88, friction 0.5, step 1e-4 sqrt(d/g), an incline of 24 degrees and a
/// base of frozen grains. We differ in: diameters vary by a tenth; about 25 diameters deep. Returned when the flow is developed.
Scene make_chute(const SceneOptions& options);
talus_laws chute_laws();
/// What speeds of the chute are measured in: sqrt(g d) [m/s].
double chute_speed();

/// At rest are the box and its walls; grains start at random speeds, touching nobody. Law of the peers' model B. Returned before its first step.
Scene make_gas(const SceneOptions& options);
talus_laws gas_laws();

} // namespace talus::bench
