// Grains in, grains out, and copies and views of their fields.
#include <algorithm>
#include <numeric>

#include "capi/src/guard.hpp"
#include "runtime/comm/packing_buffer.hpp"

using namespace talus;
using namespace talus::capi;
using core::LocalIndex;

namespace {

enum class FieldType { real, integer32, integer64 };
struct FieldShape {
    FieldType type;
    int components;
    std::size_t bytes() const { return static_cast<std::size_t>(components) * (type == FieldType::integer32 ? 4 : 8); }
};

FieldShape shape_of(int32_t field) {
    switch (field) {
    case TALUS_FIELD_LABEL: return {FieldType::integer64, 1};
    case TALUS_FIELD_RADIUS:
    case TALUS_FIELD_MASS: return {FieldType::real, 1};
    case TALUS_FIELD_POSITION:
    case TALUS_FIELD_VELOCITY:
    case TALUS_FIELD_ANGULAR_VELOCITY:
    case TALUS_FIELD_FORCE:
    case TALUS_FIELD_TORQUE:
    case TALUS_FIELD_DISPLACEMENT: return {FieldType::real, 3};
    case TALUS_FIELD_MATERIAL:
    case TALUS_FIELD_GROUP:
    case TALUS_FIELD_COLOUR:
    case TALUS_FIELD_OWNER: return {FieldType::integer32, 1};
    default: core::fail(core::ErrorKind::argument, "field {}: not one of TALUS_FIELD_*", field);
    }
}

/// Sums of every owned grain, wherever they are kept now.
std::vector<core::ForceSum> sums_of(const runtime::Subdomain& sub) {
    if (sub.laid_out) return sub.sums;
    std::vector<core::ForceSum> sums(sub.n_owned);
    for (const core::Tile& t : sub.tiles)
        for (std::uint32_t k = 0; k < t.count; ++k) sums[t.first + k] = t.sums[k];
    return sums;
}

/// One grain's value of a field, as bytes.
class FieldReader {
public:
    FieldReader(const runtime::Engine& e, int32_t field) : s_(e.state()), field_(field) {
        if (field != TALUS_FIELD_FORCE && field != TALUS_FIELD_TORQUE) return;
        e.require_healthy(); // an error may have come between the forces of two steps
        sums_ = sums_of(s_.sub);
    }
    void read(LocalIndex i, void* out) const {
        const core::Particle& p = s_.sub.particles[i];
        switch (field_) {
        case TALUS_FIELD_LABEL: std::memcpy(out, &p.label, 8); break;
        case TALUS_FIELD_POSITION: std::memcpy(out, p.position, 24); break;
        case TALUS_FIELD_RADIUS: std::memcpy(out, &p.radius, 8); break;
        case TALUS_FIELD_VELOCITY: std::memcpy(out, p.velocity, 24); break;
        case TALUS_FIELD_ANGULAR_VELOCITY: std::memcpy(out, p.angular_velocity, 24); break;
        case TALUS_FIELD_MASS: std::memcpy(out, &p.mass, 8); break;
        case TALUS_FIELD_FORCE: scaled(sums_[i].force, s_.model.units.force.unit, out); break;
        case TALUS_FIELD_TORQUE: scaled(sums_[i].torque, s_.model.units.torque.unit, out); break;
        case TALUS_FIELD_DISPLACEMENT: {
            double d[3];
            for (int a = 0; a < 3; ++a) d[a] = p.position[a] - s_.sub.references[i][static_cast<std::size_t>(a)];
            std::memcpy(out, d, 24);
            break;
        }
        case TALUS_FIELD_MATERIAL: integer(core::material_of(p), out); break;
        case TALUS_FIELD_GROUP: integer(core::group_of(p), out); break;
        case TALUS_FIELD_COLOUR: integer(core::colour_of(p), out); break;
        default: integer(s_.comm->rank(), out); break;
        }
    }

private:
    static void integer(int v, void* out) {
        const int32_t n = v;
        std::memcpy(out, &n, 4);
    }
    static void scaled(const std::int64_t* v, double unit, void* out) {
        const double d[3] = {static_cast<double>(v[0]) * unit, static_cast<double>(v[1]) * unit, static_cast<double>(v[2]) * unit};
        std::memcpy(out, d, 24);
    }

    const runtime::EngineState& s_;
    int32_t field_;
    std::vector<core::ForceSum> sums_;
};

/// Owned grains in the order of their labels.
std::vector<LocalIndex> by_label(const runtime::Subdomain& sub) {
    std::vector<LocalIndex> order(sub.n_owned);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](LocalIndex a, LocalIndex b) { return sub.particles[a].label < sub.particles[b].label; });
    return order;
}

void require_capacity(std::int64_t capacity, std::int64_t count, const void* data, int64_t* out_count) {
    if (out_count != nullptr) *out_count = count;
    if (capacity < count) core::fail(core::ErrorKind::argument, "capacity {} is less than the {} grains", capacity, count);
    if (count > 0) require(data, "out_data");
}

} // namespace

extern "C" {

talus_status talus_particles_insert(talus_engine* engine, const talus_particles* particles, double max_overlap) {
    return with_engine(engine, [&](runtime::Engine& e) {
        std::vector<runtime::NewGrain> grains;
        runtime::agree(*e.state().comm, [&] {
            talus_particles none{};
            none.struct_size = sizeof none;
            const talus_particles c = read_struct(particles, "particles", none);
            if (c.count < 0) core::fail(core::ErrorKind::argument, "particles.count = {}: must be >= 0", c.count);
            if (c.count > 0) {
                require(c.label, "particles.label");
                require(c.position, "particles.position");
                require(c.radius, "particles.radius");
            }
            grains.resize(static_cast<std::size_t>(c.count));
            for (std::size_t k = 0; k < grains.size(); ++k) {
                runtime::NewGrain& g = grains[k];
                g.label = c.label[k];
                g.radius = c.radius[k];
                for (std::size_t a = 0; a < 3; ++a) {
                    g.position[a] = c.position[3 * k + a];
                    g.velocity[a] = c.velocity != nullptr ? c.velocity[3 * k + a] : 0.0;
                    g.angular_velocity[a] = c.angular_velocity != nullptr ? c.angular_velocity[3 * k + a] : 0.0;
                }
                g.material = c.material != nullptr ? c.material[k] : 0;
                g.group = c.group != nullptr ? c.group[k] : 0;
                g.colour = c.colour != nullptr ? c.colour[k] : 0;
            }
        });
        e.insert(grains, max_overlap);
    });
}

talus_status talus_particles_init(talus_particles* out) { return init_struct(out, talus_particles{}); }
talus_status talus_view_init(talus_view* out) { return init_struct(out, talus_view{}); }

talus_status talus_fill_init(talus_fill* out) {
    talus_fill f{};
    f.first_label = 1;
    f.jitter = 1.0;
    f.room = 0.1;
    return init_struct(out, f);
}

talus_status talus_particles_fill(talus_engine* engine, const talus_fill* fill, int64_t* out_count) {
    return with_engine(engine, [&](runtime::Engine& e) {
        talus_fill defaults{};
        talus_fill_init(&defaults);
        const talus_fill c = read_struct(fill, "fill", defaults);
        core::FillPlan plan;
        for (int a = 0; a < 3; ++a) {
            plan.lo[a] = c.lo[a];
            plan.hi[a] = c.hi[a];
        }
        plan.radius_min = c.radius_min;
        plan.radius_max = c.radius_max;
        plan.jitter = c.jitter;
        plan.room = c.room;
        const std::int64_t n = e.fill(plan, c.count, c.first_label, c.material, c.group);
        if (out_count != nullptr) *out_count = n;
    });
}

talus_status talus_particles_add_velocity(talus_engine* engine, const double velocity[3]) {
    return with_engine(engine, [&](runtime::Engine& e) {
        require(velocity, "velocity");
        const double v[3] = {velocity[0], velocity[1], velocity[2]};
        e.add_velocity(v);
    });
}

talus_status talus_particles_stop(talus_engine* engine) {
    return with_engine(engine, [](runtime::Engine& e) { e.stop_grains(); });
}

talus_status talus_particles_colour_layers(talus_engine* engine, int32_t axis, double origin, double thickness) {
    return with_engine(engine, [&](runtime::Engine& e) { e.colour_layers(axis, origin, thickness); });
}

talus_status talus_particles_remove_above(talus_engine* engine, int32_t axis, double level, int64_t* out_removed) {
    return with_engine(engine, [&](runtime::Engine& e) {
        const std::int64_t n = e.remove_above(axis, level);
        if (out_removed != nullptr) *out_removed = n;
    });
}

talus_status talus_particles_remove_box(talus_engine* engine, const double lo[3], const double hi[3], int64_t* out_removed) {
    return with_engine(engine, [&](runtime::Engine& e) {
        double from[3], to[3];
        runtime::agree(*e.state().comm, [&] { read_box(lo, hi, from, to); });
        const std::int64_t n = e.remove_box(from, to);
        if (out_removed != nullptr) *out_removed = n;
    });
}

talus_status talus_particles_remove(talus_engine* engine, int64_t count, const int64_t* labels, int64_t* out_removed) {
    return with_engine(engine, [&](runtime::Engine& e) {
        std::vector<core::Label> mine;
        runtime::agree(*e.state().comm, [&] {
            if (count < 0) core::fail(core::ErrorKind::argument, "count = {}: must be >= 0", count);
            if (count > 0) require(labels, "labels");
            mine.assign(labels, labels + count);
        });
        const std::int64_t n = e.remove_labels(mine);
        if (out_removed != nullptr) *out_removed = n;
    });
}

talus_status talus_particles_mark_reference(talus_engine* engine) {
    return with_engine(engine, [](runtime::Engine& e) { e.mark_reference(); });
}

talus_status talus_particles_copy(talus_engine* engine, int32_t field, int64_t capacity, void* out_data, int64_t* out_count) {
    return with_engine(engine, [&](runtime::Engine& e) {
        const runtime::EngineState& s = e.state();
        const std::size_t bytes = shape_of(field).bytes();
        require_capacity(capacity, s.sub.n_owned, out_data, out_count);
        const FieldReader reader(e, field);
        auto* out = static_cast<std::byte*>(out_data);
        for (const LocalIndex i : by_label(s.sub)) {
            reader.read(i, out);
            out += bytes;
        }
    });
}

talus_status talus_particles_gather(talus_engine* engine, int32_t field, int64_t capacity, void* out_data, int64_t* out_count) {
    return with_engine(engine, [&](runtime::Engine& e) {
        runtime::EngineState& s = e.state();
        const std::size_t bytes = shape_of(field).bytes();
        const std::size_t item = sizeof(core::Label) + bytes;
        const FieldReader reader(e, field);
        runtime::Bytes mine(s.sub.n_owned * item);
        for (LocalIndex i = 0; i < s.sub.n_owned; ++i) {
            std::memcpy(mine.data() + i * item, &s.sub.particles[i].label, sizeof(core::Label));
            reader.read(i, mine.data() + i * item + sizeof(core::Label));
        }
        const std::vector<runtime::Bytes> all = s.comm->gather(mine);
        runtime::agree(*s.comm, [&] {
            if (s.comm->rank() != 0) {
                if (out_count != nullptr) *out_count = 0;
                return;
            }
            std::vector<std::pair<core::Label, const std::byte*>> items;
            for (const runtime::Bytes& part : all)
                for (std::size_t at = 0; at < part.size(); at += item) {
                    core::Label label;
                    std::memcpy(&label, part.data() + at, sizeof label);
                    items.emplace_back(label, part.data() + at + sizeof label);
                }
            require_capacity(capacity, static_cast<std::int64_t>(items.size()), out_data, out_count);
            std::sort(items.begin(), items.end());
            auto* out = static_cast<std::byte*>(out_data);
            for (const auto& [label, from] : items) {
                std::memcpy(out, from, bytes);
                out += bytes;
            }
        });
    });
}

talus_status talus_particles_view(talus_engine* engine, int32_t field, talus_view* out_view) {
    return with_engine(engine, [&](runtime::Engine& e) {
        static const core::Particle empty{};
        const runtime::Subdomain& sub = e.state().sub;
        const core::Particle& p = sub.n_owned > 0 ? sub.particles.front() : empty;
        talus_view v{};
        v.components = shape_of(field).components;
        v.count = sub.n_owned;
        v.stride = sizeof(core::Particle);
        v.generation = e.generation();
        switch (field) {
        case TALUS_FIELD_POSITION: v.data = p.position; break;
        case TALUS_FIELD_RADIUS: v.data = &p.radius; break;
        case TALUS_FIELD_VELOCITY: v.data = p.velocity; break;
        case TALUS_FIELD_ANGULAR_VELOCITY: v.data = p.angular_velocity; break;
        case TALUS_FIELD_MASS: v.data = &p.mass; break;
        default: core::fail(core::ErrorKind::argument, "field {} has no view; use talus_particles_copy", field);
        }
        write_struct(out_view, "out_view", v);
    });
}

talus_status talus_engine_generation(const talus_engine* engine, uint64_t* out_generation) {
    return with_engine<LastStep::as_it_is>(engine, [&](runtime::Engine& e) {
        require(out_generation, "out_generation");
        *out_generation = e.generation();
    });
}

} // extern "C"
