#include "apps/bench/grains.hpp"

#include <fstream>

#include <fmt/format.h>

#include "apps/bench/scene.hpp"

namespace talus::bench {

void Grains::add(std::int64_t of_label, const std::array<double, 3>& at, double of_radius, const std::array<double, 3>& moving, std::int32_t of_group) {
    label.push_back(of_label);
    position.insert(position.end(), at.begin(), at.end());
    radius.push_back(of_radius);
    velocity.insert(velocity.end(), moving.begin(), moving.end());
    spin.insert(spin.end(), 3, 0.0);
    group.push_back(of_group);
}

std::array<double, 3> mean_velocity(const Grains& grains) {
    std::array<double, 3> sum{};
    double n = 0.0;
    for (std::size_t k = 0; k < grains.count(); ++k) {
        if (grains.group[k] == kFrozen) continue;
        n += 1.0;
        for (std::size_t a = 0; a < 3; ++a) sum[a] += grains.velocity[3 * k + a];
    }
    for (double& v : sum) v = n > 0.0 ? v / n : 0.0;
    return sum;
}

void insert(talus_engine* engine, const Grains& grains, double max_overlap) {
    talus_particles p;
    check(talus_particles_init(&p), engine);
    p.count = static_cast<std::int64_t>(grains.count());
    p.label = grains.label.data();
    p.position = grains.position.data();
    p.radius = grains.radius.data();
    p.velocity = grains.velocity.data();
    p.angular_velocity = grains.spin.data();
    p.group = grains.group.data();
    check(talus_particles_insert(engine, &p, max_overlap), engine);
}

Grains gather(talus_engine* engine) {
    talus_state state;
    check(talus_state_init(&state), engine);
    check(talus_engine_state(engine, &state), engine);
    Grains g;
    std::int64_t n = state.particles;
    const auto column = [&](int field, auto& data, std::int64_t components) {
        data.resize(static_cast<std::size_t>(n * components));
        std::int64_t count = 0;
        check(talus_particles_gather(engine, field, n, data.data(), &count), engine);
    };
    column(TALUS_FIELD_LABEL, g.label, 1);
    column(TALUS_FIELD_POSITION, g.position, 3);
    column(TALUS_FIELD_RADIUS, g.radius, 1);
    column(TALUS_FIELD_VELOCITY, g.velocity, 3);
    column(TALUS_FIELD_ANGULAR_VELOCITY, g.spin, 3);
    column(TALUS_FIELD_GROUP, g.group, 1);
    return g;
}

void write_bed(const std::string& path, const std::string& axes, const std::array<double, 3>& lo, const std::array<double, 3>& hi, const Grains& grains) {
    std::array<std::size_t, 3> ours{}; // which of our axes stands at each place of the file
    for (std::size_t a = 0; a < 3; ++a) ours[static_cast<std::size_t>(axes[a] - 'x')] = a;
    std::ofstream file(path);
    file << fmt::format("# {}", grains.count());
    for (const std::size_t a : ours) file << fmt::format(" {} {}", lo[a], hi[a]);
    for (std::size_t k = 0; k < grains.count(); ++k) {
        file << fmt::format("\n{}", grains.label[k]);
        for (const std::size_t a : ours) file << fmt::format(" {}", grains.position[3 * k + a]);
        file << fmt::format(" {}", grains.radius[k]);
        for (const std::size_t a : ours) file << fmt::format(" {}", grains.velocity[3 * k + a]);
    }
    file << "\n";
    file.close();
    if (!file) core::fail(core::ErrorKind::io, "{}: could not be written", path);
}

} // namespace talus::bench
