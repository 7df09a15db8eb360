// engine.hpp: a thin owner of a serial talus_engine for tests. Nothing here knows physics: it names the calls of
// talus.h, keeps the handle, and turns every status other than TALUS_OK into a TalusError with the engine's text.
#pragma once

#include <talus.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace talus::test {

using Vec3 = std::array<double, 3>;

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(const Vec3& a) { return std::sqrt(dot(a, a)); }

class TalusError : public std::runtime_error {
public:
    TalusError(talus_status status, const std::string& text)
        : std::runtime_error(std::string(talus_status_string(status)) + ": " + text), status(status) {}
    talus_status status;
};

/// A grain as a test writes it down; labels are given in order of insertion, from zero.
struct Grain {
    Vec3 position{};
    double radius = 0.0;
    Vec3 velocity{};
    Vec3 spin{};
    int32_t material = 0;
    int32_t group = 0;
};

struct Stress {
    std::array<double, 9> tensor{}; // row major, compression negative
    double solid_fraction = 0.0;
    double coordination = 0.0;
};

/// Settings with a closed domain and the step given; gravity off, no rolling resistance, any step up to Rayleigh's.
/// Tests switch on what they are about.
inline talus_settings bare_settings(const Vec3& lo, const Vec3& hi, double time_step) {
    talus_settings settings;
    talus_settings_init(&settings);
    for (int axis = 0; axis < 3; ++axis) {
        settings.domain_lo[axis] = lo[axis];
        settings.domain_hi[axis] = hi[axis];
        settings.gravity[axis] = 0.0;
    }
    settings.time_step = time_step;
    settings.time_step_limit = 1.0;
    settings.laws.rolling = TALUS_ROLLING_NONE;
    return settings;
}

class Engine {
public:
    explicit Engine(const talus_settings& settings) {
        const talus_status status = talus_engine_create(&settings, &engine_);
        if (status != TALUS_OK) throw TalusError(status, talus_message());
    }
    Engine(Engine&& other) noexcept : engine_(std::exchange(other.engine_, nullptr)), next_label_(other.next_label_) {}
    Engine(const Engine&) = delete;
    Engine& operator=(const Engine&) = delete;
    Engine& operator=(Engine&&) = delete;
    ~Engine() { talus_engine_destroy(engine_); }

    talus_engine* handle() { return engine_; }

    int32_t material(double young, double poisson, double density) {
        talus_material material;
        talus_material_init(&material);
        material.young = young;
        material.poisson = poisson;
        material.density = density;
        return add(material);
    }
    int32_t rigid_material() {
        talus_material material;
        talus_material_init(&material);
        material.rigid = 1;
        return add(material);
    }
    void contact(int32_t a, int32_t b, double restitution, double friction, double rolling_friction = 0.0) {
        talus_contact contact;
        talus_contact_init(&contact);
        contact.restitution = restitution;
        contact.friction = friction;
        contact.rolling_friction = rolling_friction;
        check(talus_contact_set(engine_, a, b, &contact));
    }
    int32_t wall(int32_t material, const Vec3& point, const Vec3& normal, const Vec3& velocity = {}) {
        talus_wall wall;
        talus_wall_init(&wall);
        wall.material = material;
        for (int axis = 0; axis < 3; ++axis) {
            wall.point[axis] = point[axis];
            wall.normal[axis] = normal[axis];
            wall.velocity[axis] = velocity[axis];
        }
        int32_t id = -1;
        check(talus_wall_add(engine_, &wall, &id));
        return id;
    }
    void wall_velocity(int32_t wall, const Vec3& velocity) { check(talus_wall_set_velocity(engine_, wall, velocity.data())); }

    void insert(const std::vector<Grain>& grains, double max_overlap = 0.05) {
        const std::size_t n = grains.size();
        std::vector<int64_t> label(n);
        std::vector<double> position(3 * n), radius(n), velocity(3 * n), spin(3 * n);
        std::vector<int32_t> material(n), group(n);
        for (std::size_t i = 0; i < n; ++i) {
            label[i] = next_label_ + static_cast<int64_t>(i);
            radius[i] = grains[i].radius;
            material[i] = grains[i].material;
            group[i] = grains[i].group;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                position[3 * i + axis] = grains[i].position[axis];
                velocity[3 * i + axis] = grains[i].velocity[axis];
                spin[3 * i + axis] = grains[i].spin[axis];
            }
        }
        talus_particles particles{};
        particles.struct_size = sizeof particles;
        particles.count = static_cast<int64_t>(n);
        particles.label = label.data();
        particles.position = position.data();
        particles.radius = radius.data();
        particles.velocity = velocity.data();
        particles.angular_velocity = spin.data();
        particles.material = material.data();
        particles.group = group.data();
        check(talus_particles_insert(engine_, &particles, max_overlap));
        next_label_ += static_cast<int64_t>(n);
    }
    /// Fill a box at random; labels are 0, 1, 2 ... and no other grains may be there. Returns the number of grains.
    int64_t fill(const Vec3& lo, const Vec3& hi, double radius_min, double radius_max, int64_t count, int32_t material, double room) {
        talus_fill fill;
        talus_fill_init(&fill);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            fill.lo[axis] = lo[axis];
            fill.hi[axis] = hi[axis];
        }
        fill.radius_min = radius_min;
        fill.radius_max = radius_max;
        fill.count = count;
        fill.material = material;
        fill.room = room;
        fill.first_label = next_label_;
        int64_t placed = 0;
        check(talus_particles_fill(engine_, &fill, &placed));
        next_label_ += placed;
        return placed;
    }
    void group(int32_t group, int32_t mode, const Vec3& velocity = {}, const Vec3& spin = {}) {
        check(talus_group_set(engine_, group, mode, velocity.data(), spin.data()));
    }
    void stop_grains() { check(talus_particles_stop(engine_)); }
    void laws(const talus_laws& laws) { check(talus_engine_set_laws(engine_, &laws)); }
    void gravity(const Vec3& gravity) { check(talus_engine_set_gravity(engine_, gravity.data())); }
    void time_step(double step) { check(talus_engine_set_time_step(engine_, step)); }

    /// Zero steps prepare: forces of the present positions become readable.
    void step(int64_t n_steps = 0) { check(talus_engine_step(engine_, n_steps, nullptr)); }

    double critical_step() {
        double step = 0.0;
        check(talus_engine_critical_step(engine_, &step));
        return step;
    }
    talus_state state() {
        talus_state state;
        talus_state_init(&state);
        check(talus_engine_state(engine_, &state));
        return state;
    }
    talus_energy energy() {
        talus_energy energy;
        talus_energy_init(&energy);
        check(talus_engine_energy(engine_, &energy));
        return energy;
    }
    talus_wall_state wall_state(int32_t wall) {
        talus_wall_state state{};
        state.struct_size = sizeof state;
        check(talus_wall_get(engine_, wall, &state));
        return state;
    }
    /// Of the grains on the wall.
    Vec3 wall_force(int32_t wall) { return std::to_array(wall_state(wall).force); }
    Stress stress(const Vec3& lo, const Vec3& hi) {
        Stress stress;
        check(talus_engine_stress(engine_, lo.data(), hi.data(), stress.tensor.data(), &stress.solid_fraction, &stress.coordination));
        return stress;
    }
    std::pair<std::array<int64_t, 3>, double> internal_force_sum() {
        std::pair<std::array<int64_t, 3>, double> sum{};
        check(talus_engine_internal_force_sum(engine_, sum.first.data(), &sum.second));
        return sum;
    }

    // Fields, by label.
    std::vector<Vec3> positions() { return vectors(TALUS_FIELD_POSITION); }
    std::vector<Vec3> velocities() { return vectors(TALUS_FIELD_VELOCITY); }
    std::vector<Vec3> spins() { return vectors(TALUS_FIELD_ANGULAR_VELOCITY); }
    std::vector<Vec3> forces() { return vectors(TALUS_FIELD_FORCE); }
    std::vector<Vec3> torques() { return vectors(TALUS_FIELD_TORQUE); }
    std::vector<double> radii() { return scalars(TALUS_FIELD_RADIUS); }
    std::vector<double> masses() { return scalars(TALUS_FIELD_MASS); }

private:
    void check(talus_status status) const {
        if (status != TALUS_OK) throw TalusError(status, talus_engine_message(engine_));
    }
    int32_t add(const talus_material& material) {
        int32_t id = -1;
        check(talus_material_add(engine_, &material, &id));
        return id;
    }
    std::vector<Vec3> vectors(int32_t field) {
        std::vector<Vec3> values(static_cast<std::size_t>(next_label_));
        copy(field, values.data());
        return values;
    }
    std::vector<double> scalars(int32_t field) {
        std::vector<double> values(static_cast<std::size_t>(next_label_));
        copy(field, values.data());
        return values;
    }
    void copy(int32_t field, void* data) {
        int64_t count = 0;
        check(talus_particles_copy(engine_, field, next_label_, data, &count));
        if (count != next_label_) throw std::runtime_error("grains were lost: fields are shorter than what was inserted");
    }

    talus_engine* engine_ = nullptr;
    int64_t next_label_ = 0; // and the number of grains
};

} // namespace talus::test
