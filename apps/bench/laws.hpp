// apps/bench/laws.hpp: the combinations of laws that are measured on the bed, by name.
#pragma once

#include "apps/bench/scene.hpp"

namespace talus::bench {

struct NamedLaws {
    const char* name;
    std::int32_t normal, damping, tangential, rolling;

    talus_laws laws() const {
        talus_laws l;
        talus_laws_init(&l);
        l.normal = normal;
        l.damping = damping;
        l.tangential = tangential;
        l.rolling = rolling;
        l.stiffness_n = 1e3;
        return l;
    }
};

inline constexpr NamedLaws kLaws[] = {
    {"default", TALUS_NORMAL_HERTZ, TALUS_DAMPING_CLIPPED, TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_ROLLING_CONSTANT},
    {"default_spring", TALUS_NORMAL_HERTZ, TALUS_DAMPING_CLIPPED, TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_ROLLING_SPRING},
    {"displacement_spring_attractive", TALUS_NORMAL_HERTZ, TALUS_DAMPING_ATTRACTIVE, TALUS_TANGENTIAL_DISPLACEMENT, TALUS_ROLLING_SPRING},
    {"displacement_constant_attractive", TALUS_NORMAL_HERTZ, TALUS_DAMPING_ATTRACTIVE, TALUS_TANGENTIAL_DISPLACEMENT, TALUS_ROLLING_CONSTANT},
    {"displacement_attractive", TALUS_NORMAL_HERTZ, TALUS_DAMPING_ATTRACTIVE, TALUS_TANGENTIAL_DISPLACEMENT, TALUS_ROLLING_NONE},
    {"linear", TALUS_NORMAL_LINEAR, TALUS_DAMPING_CLIPPED, TALUS_TANGENTIAL_FORCE, TALUS_ROLLING_CONSTANT},
    {"frictionless", TALUS_NORMAL_HERTZ, TALUS_DAMPING_CLIPPED, TALUS_TANGENTIAL_NONE, TALUS_ROLLING_NONE},
};

} // namespace talus::bench
