// Laws, materials, walls and groups.
#include "capi/src/guard.hpp"
#include "runtime/phase/observe.hpp"

using namespace talus;
using namespace talus::capi;

namespace {

template <class Struct>
Struct blank() {
    Struct s{};
    s.struct_size = sizeof(Struct);
    return s;
}

core::Vec3d vec3(const double* v) { return {v[0], v[1], v[2]}; }
void put(const core::Vec3d& v, double* out) {
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

/// A vector argument, copied; NULL is zero where `optional`.
struct Vector {
    double v[3] = {0.0, 0.0, 0.0};
    Vector(const double* from, const char* name, bool optional = false) {
        if (from == nullptr && optional) return;
        require(from, name);
        for (int a = 0; a < 3; ++a) v[a] = from[a];
    }
};

} // namespace

extern "C" {

talus_status talus_engine_set_laws(talus_engine* engine, const talus_laws* laws) {
    return with_engine(engine, [&](runtime::Engine& e) {
        require(laws, "laws");
        e.set_laws(to_laws(*laws));
    });
}

talus_status talus_engine_set_time_step(talus_engine* engine, double time_step) {
    return with_engine(engine, [&](runtime::Engine& e) { e.set_time_step(time_step); });
}

talus_status talus_engine_set_gravity(talus_engine* engine, const double gravity[3]) {
    return with_engine(engine, [&](runtime::Engine& e) { e.set_gravity(Vector(gravity, "gravity").v); });
}

talus_status talus_engine_critical_step(talus_engine* engine, double* out_step) {
    return with_engine(engine, [&](runtime::Engine& e) {
        require(out_step, "out_step");
        *out_step = e.critical_step();
    });
}

talus_status talus_material_init(talus_material* out) { return init_struct(out, blank<talus_material>()); }
talus_status talus_contact_init(talus_contact* out) {
    talus_contact c = blank<talus_contact>();
    c.restitution = 1.0;
    return init_struct(out, c);
}

talus_status talus_material_add(talus_engine* engine, const talus_material* material, int32_t* out_id) {
    return with_engine(engine, [&](runtime::Engine& e) {
        const talus_material c = read_struct(material, "material", blank<talus_material>());
        core::Material m;
        m.rigid = c.rigid != 0;
        m.young = c.young;
        m.poisson = c.poisson;
        m.density = c.density;
        const int id = e.add_material(m);
        if (out_id != nullptr) *out_id = id;
    });
}

talus_status talus_contact_set(talus_engine* engine, int32_t material_a, int32_t material_b, const talus_contact* contact) {
    return with_engine(engine, [&](runtime::Engine& e) {
        const talus_contact c = read_struct(contact, "contact", blank<talus_contact>());
        core::ContactMaterial m;
        m.restitution = c.restitution;
        m.friction = c.friction;
        m.rolling_friction = c.rolling_friction;
        e.set_contact(material_a, material_b, m);
    });
}

talus_status talus_wall_init(talus_wall* out) { return init_struct(out, blank<talus_wall>()); }

talus_status talus_wall_state_init(talus_wall_state* out) { return init_struct(out, blank<talus_wall_state>()); }

talus_status talus_wall_add(talus_engine* engine, const talus_wall* wall, int32_t* out_id) {
    return with_engine(engine, [&](runtime::Engine& e) {
        const talus_wall c = read_struct(wall, "wall", blank<talus_wall>());
        const int id = e.add_wall({vec3(c.point), vec3(c.normal), vec3(c.velocity), c.material});
        if (out_id != nullptr) *out_id = id;
    });
}

talus_status talus_wall_set_velocity(talus_engine* engine, int32_t wall, const double velocity[3]) {
    return with_engine<LastStep::as_it_is>(engine, [&](runtime::Engine& e) { e.set_wall_velocity(wall, Vector(velocity, "velocity").v); });
}

talus_status talus_wall_get(talus_engine* engine, int32_t wall, talus_wall_state* out_state) {
    return with_engine<LastStep::as_it_is>(engine, [&](runtime::Engine& e) {
        const auto& walls = e.state().model.walls;
        if (wall < 0 || wall >= static_cast<int32_t>(walls.size())) core::fail(core::ErrorKind::argument, "wall {}: there are walls 0 to {}", wall, static_cast<int>(walls.size()) - 1);
        require_on_all(e, out_state, "out_state");
        const runtime::WallObservation o = runtime::observe_wall(e.state(), wall);
        const core::WallPlane& plane = walls[static_cast<std::size_t>(wall)].plane;
        talus_wall_state s = blank<talus_wall_state>();
        s.contacts = static_cast<int32_t>(o.contacts);
        put(plane.point, s.point);
        put(plane.velocity, s.velocity);
        put(o.force, s.force);
        put(o.torque, s.torque);
        s.work = e.wall_work(wall);
        write_struct(out_state, "out_state", s);
    });
}

talus_status talus_group_set(talus_engine* engine, int32_t group, int32_t mode, const double velocity[3], const double angular_velocity[3]) {
    return with_engine(engine, [&](runtime::Engine& e) {
        core::GroupMotion m;
        m.mode = static_cast<core::GroupMotion::Mode>(mode);
        const Vector v(velocity, "velocity", true), w(angular_velocity, "angular_velocity", true);
        for (int a = 0; a < 3; ++a) {
            m.velocity[a] = v.v[a];
            m.angular_velocity[a] = w.v[a];
        }
        e.set_group(group, m);
    });
}

} // extern "C"
