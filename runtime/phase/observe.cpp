// observe: order-free sums over grains and contacts.
#include "runtime/phase/observe.hpp"

#include <algorithm>
#include <cmath>

#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::ContactView;
using core::Particle;
using core::Tile;
using core::Wide;

namespace {

/// Finer than the units of kernels by 2^40: energies of slow grains are far below the cap.
constexpr double kFiner = 1099511627776.0;

/// A tile's share of sums: integers, so that tiles and ranks add in any order.
struct Sums {
    enum : int { kinetic, rotational, elastic_normal, elastic_tangential, elastic_rolling, gravity, net, contact, stress0, volume = stress0 + 9, coordination, in_box, kCount };
    Wide v[kCount] = {};
    std::int64_t contacts = 0, wall_contacts = 0, sliding = 0;
    double max_speed_squared = 0.0, max_overlap = 0.0;

    void add(int k, double value, double scale) { v[k] += core::to_units(value, scale * kFiner); }
    void merge(const Sums& o) {
        for (int k = 0; k < kCount; ++k) v[k] += o.v[k];
        contacts += o.contacts;
        wall_contacts += o.wall_contacts;
        sliding += o.sliding;
        max_speed_squared = std::max(max_speed_squared, o.max_speed_squared);
        max_overlap = std::max(max_overlap, o.max_overlap);
    }
};

/// Visit every contact that this rank counts: pairs at the owner of the smaller label, and all of its wall contacts.
template <class Visit>
void each_contact(const EngineState& s, const core::ForceContext& context, const Tile& tile, Visit visit) {
    const core::ProbeSet probes = core::select_probes(context.laws);
    const core::TileIds ids{s.sub.particles.data(), s.sub.n_owned, tile.index_of.data()};
    for (std::uint32_t k = 0; k < tile.pairs.n_contacts; ++k)
        if (tile.pairs.touches(k) && tile.index_of[tile.pairs.contacts[k].i] < s.sub.n_owned) visit(probes.pair(context, ids, tile.pairs, k));
    for (std::size_t w = 0; w < tile.walls.size(); ++w)
        for (std::uint32_t k = 0; k < tile.walls[w].n_contacts; ++k)
            if (tile.walls[w].touches(k)) visit(probes.wall(context, s.model.walls[w].plane, static_cast<int>(w), ids, tile.walls[w], k));
}

/// body(tile, sums) for every tile, summed over tiles and ranks.
template <class Body>
Sums reduce(EngineState& s, Body body) {
    std::vector<Sums> parts(s.sub.tiles.size());
    s.workers.for_each(Phase::observe, static_cast<int>(s.sub.tiles.size()), [&](int t) { body(s.sub.tiles[t], parts[t]); });
    Sums sum;
    for (const Sums& p : parts) sum.merge(p);
    s.comm->sum(sum.v, Sums::kCount);
    std::vector<std::int64_t> counts{sum.contacts, sum.wall_contacts, sum.sliding};
    s.comm->sum(counts);
    sum.contacts = counts[0];
    sum.wall_contacts = counts[1];
    sum.sliding = counts[2];
    std::vector<double> largest{sum.max_speed_squared, sum.max_overlap};
    s.comm->max(largest);
    sum.max_speed_squared = largest[0];
    sum.max_overlap = largest[1];
    return sum;
}

double norm(const core::Vec3d& v) { return std::sqrt(core::dot(v, v)); }

bool in_box(const core::Vec3d& x, const double (&lo)[3], const double (&hi)[3]) {
    return x.x >= lo[0] && x.x < hi[0] && x.y >= lo[1] && x.y < hi[1] && x.z >= lo[2] && x.z < hi[2];
}

} // namespace

Observation observe(EngineState& s) {
    const core::FixedUnits& u = s.model.units;
    const double* g = s.model.settings.gravity;
    const core::Vec3d gravity{g[0], g[1], g[2]};
    const Sums sum = reduce(s, [&](Tile& tile, Sums& out) {
        for (std::uint32_t k = 0; k < tile.count; ++k) {
            const Particle& p = s.sub.particles[tile.first + k];
            const core::Vec3d v = core::make_vec3(p.velocity), w = core::make_vec3(p.angular_velocity), x = core::make_vec3(p.position);
            const double speed_squared = core::dot(v, v);
            out.add(Sums::kinetic, 0.5 * p.mass * speed_squared, u.torque.scale);
            out.add(Sums::rotational, 0.5 * core::kSphereInertia * p.mass * (p.radius * p.radius) * core::dot(w, w), u.torque.scale);
            out.add(Sums::gravity, -p.mass * core::dot(gravity, x), u.torque.scale);
            out.max_speed_squared = std::max(out.max_speed_squared, speed_squared);
            const std::int64_t* f = tile.sums[k].force;
            const core::Vec3d contact_force{static_cast<double>(f[0]) * u.force.unit, static_cast<double>(f[1]) * u.force.unit, static_cast<double>(f[2]) * u.force.unit};
            if (s.model.groups[static_cast<std::size_t>(core::group_of(p))].mode == core::GroupMotion::Mode::free)
                out.add(Sums::net, norm(contact_force + gravity * p.mass), u.force.scale);
        }
        each_contact(s, s.force, tile, [&](const ContactView& c) {
            out.add(Sums::elastic_normal, c.elastic_normal, u.torque.scale);
            out.add(Sums::elastic_tangential, c.elastic_tangential, u.torque.scale);
            out.add(Sums::elastic_rolling, c.elastic_rolling, u.torque.scale);
            out.add(Sums::contact, norm(c.force), u.force.scale);
            out.sliding += c.sliding ? 1 : 0;
            if (c.j >= core::kWallLabel) {
                ++out.wall_contacts;
            } else {
                ++out.contacts;
                out.max_overlap = std::max(out.max_overlap, c.overlap / c.smaller_radius);
            }
        });
    });
    const auto joule = [&](int k) { return core::to_double(sum.v[k], u.torque.unit / kFiner); };
    Observation o;
    o.contacts = sum.contacts;
    o.wall_contacts = sum.wall_contacts;
    o.sliding = sum.sliding;
    o.kinetic = joule(Sums::kinetic);
    o.rotational = joule(Sums::rotational);
    o.elastic_normal = joule(Sums::elastic_normal);
    o.elastic_tangential = joule(Sums::elastic_tangential);
    o.elastic_rolling = joule(Sums::elastic_rolling);
    o.gravity = joule(Sums::gravity);
    o.max_speed = std::sqrt(sum.max_speed_squared);
    o.max_overlap = sum.max_overlap;
    const double n_contacts = static_cast<double>(sum.contacts + sum.wall_contacts);
    const double mean_contact = n_contacts > 0.0 ? core::to_double(sum.v[Sums::contact], u.force.unit / kFiner) / n_contacts : 0.0;
    if (mean_contact > 0.0) o.unbalanced = core::to_double(sum.v[Sums::net], u.force.unit / kFiner) / static_cast<double>(s.model.n_particles) / mean_contact;

    Wide heat[3] = {s.sub.heat.friction, s.sub.heat.damping, s.sub.heat.rolling};
    for (const Tile& t : s.sub.tiles) {
        heat[0] += t.heat.friction;
        heat[1] += t.heat.damping;
        heat[2] += t.heat.rolling;
    }
    s.comm->sum(heat, 3);
    o.friction = core::to_double(heat[0], u.torque.unit);
    o.damping = core::to_double(heat[1], u.torque.unit);
    o.rolling = core::to_double(heat[2], u.torque.unit);
    return o;
}

core::Digest digest(EngineState& s) {
    std::vector<core::Digest> parts(s.sub.tiles.size());
    s.workers.for_each(Phase::observe, static_cast<int>(s.sub.tiles.size()), [&](int t) {
        const Tile& tile = s.sub.tiles[t];
        core::Digest& d = parts[t];
        for (std::uint32_t k = 0; k < tile.count; ++k) d.add_grain(s.sub.particles[tile.first + k], tile.sums[k]);
        const auto add = [&](const core::ContactList& list, std::uint32_t k, core::LocalIndex i, core::Label partner) {
            double row[core::kMaxHistoryDoubles];
            list.get_history(k, row);
            d.add_contact(s.sub.particles[i].label, partner, row, list.history_doubles);
        };
        for (std::uint32_t k = 0; k < tile.pairs.n_contacts; ++k) {
            const core::CandidatePair p = tile.pairs.contacts[k];
            if (tile.pairs.touches(k) && tile.index_of[p.i] < s.sub.n_owned) add(tile.pairs, k, tile.index_of[p.i], s.sub.particles[tile.index_of[p.j]].label);
        }
        for (std::size_t w = 0; w < tile.walls.size(); ++w)
            for (std::uint32_t k = 0; k < tile.walls[w].n_contacts; ++k)
                if (tile.walls[w].touches(k)) add(tile.walls[w], k, tile.index_of[tile.walls[w].contacts[k].i], core::kWallLabel + static_cast<core::Label>(w));
    });
    core::Digest sum;
    for (const core::Digest& d : parts) {
        sum.lo += d.lo;
        sum.hi += d.hi;
    }
    sum.lo = s.comm->sum_modulo(sum.lo);
    sum.hi = s.comm->sum_modulo(sum.hi);
    for (std::size_t w = 0; w < s.model.walls.size(); ++w) {
        const core::WallPlane& p = s.model.walls[w].plane;
        const double pose[10] = {static_cast<double>(w), p.point.x, p.point.y, p.point.z, p.normal.x, p.normal.y, p.normal.z, p.velocity.x, p.velocity.y, p.velocity.z};
        sum.add(pose, sizeof pose);
    }
    const struct {
        std::int64_t step;
        double time;
    } clock{s.model.step, s.model.time};
    sum.add(&clock, sizeof clock);
    return sum;
}

WallObservation observe_wall(EngineState& s, int wall) {
    Wide v[7] = {};
    if (static_cast<std::size_t>(wall) < s.sub.wall_last.size()) {
        const core::WallSum& w = s.sub.wall_last[static_cast<std::size_t>(wall)];
        for (int c = 0; c < 3; ++c) {
            v[c] = w.force[c];
            v[3 + c] = w.torque[c];
        }
        v[6] = w.contacts;
    }
    s.comm->sum(v, 7);
    const double f = s.model.units.force.unit, t = s.model.units.wall_torque.unit;
    return {{core::to_double(v[0], f), core::to_double(v[1], f), core::to_double(v[2], f)}, {core::to_double(v[3], t), core::to_double(v[4], t), core::to_double(v[5], t)}, static_cast<std::int64_t>(v[6])};
}

StressObservation observe_stress(EngineState& s, const double (&lo)[3], const double (&hi)[3]) {
    const core::FixedUnits& u = s.model.units;
    const double volume = (hi[0] - lo[0]) * (hi[1] - lo[1]) * (hi[2] - lo[2]);
    const auto add_outer = [&](Sums& out, const core::Vec3d& a, const core::Vec3d& b) {
        const double x[3] = {a.x, a.y, a.z}, y[3] = {b.x, b.y, b.z};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) out.add(Sums::stress0 + 3 * i + j, x[i] * y[j], u.torque.scale);
    };
    const double volume_scale = 1.0 / (u.torque.unit); // any power of two that keeps a grain's volume well above one unit
    const Sums sum = reduce(s, [&](Tile& tile, Sums& out) {
        for (std::uint32_t k = 0; k < tile.count; ++k) {
            const Particle& p = s.sub.particles[tile.first + k];
            if (!in_box(core::make_vec3(p.position), lo, hi)) continue;
            out.add(Sums::volume, 4.0 / 3.0 * core::kPi * p.radius * p.radius * p.radius, volume_scale);
            out.v[Sums::in_box] += 1;
            const core::Vec3d v = core::make_vec3(p.velocity);
            add_outer(out, v * -p.mass, v);
        }
        each_contact(s, s.force, tile, [&](const ContactView& c) {
            // A contact of grains counts where they touch; one with a wall, which lies on the edge of any box of the sand,
            // where its grain is.
            const core::Vec3d xi = core::make_vec3(s.sub.particles[c.particle_i].position);
            if (in_box(c.j >= core::kWallLabel ? xi : contact_point(s, c), lo, hi)) add_outer(out, -c.force, c.branch);
            out.v[Sums::coordination] += in_box(xi, lo, hi) ? 1 : 0;
            if (c.j < core::kWallLabel && in_box(core::make_vec3(s.sub.particles[c.particle_j].position), lo, hi)) out.v[Sums::coordination] += 1;
        });
    });
    StressObservation o;
    for (int k = 0; k < 9; ++k) o.stress[k] = core::to_double(sum.v[Sums::stress0 + k], u.torque.unit / kFiner) / volume;
    o.solid_fraction = core::to_double(sum.v[Sums::volume], 1.0 / (volume_scale * kFiner)) / volume;
    o.coordination = sum.v[Sums::in_box] > 0 ? static_cast<double>(sum.v[Sums::coordination]) / static_cast<double>(sum.v[Sums::in_box]) : 0.0;
    return o;
}

core::Vec3d contact_point(const EngineState& s, const ContactView& c) {
    const Particle& i = s.sub.particles[c.particle_i];
    const core::Vec3d at = core::make_vec3(i.position) - c.normal * (i.radius - 0.5 * c.overlap);
    core::Reference none{};
    double wrapped[3] = {at.x, at.y, at.z};
    core::wrap(s.model.settings.domain, wrapped, none);
    return core::make_vec3(wrapped);
}

std::vector<ContactRow> list_contacts(EngineState& s, const std::function<core::Vec3d(const ContactView&)>& value) {
    std::vector<std::vector<ContactRow>> parts(s.sub.tiles.size());
    s.workers.for_each(Phase::observe, static_cast<int>(parts.size()), [&](int t) { each_contact(s, s.force, s.sub.tiles[t], [&](const ContactView& c) { parts[t].push_back({c.i, c.j, value(c)}); }); });
    std::vector<ContactRow> all;
    for (std::vector<ContactRow>& part : parts) {
        all.insert(all.end(), part.begin(), part.end());
        part = {};
    }
    std::sort(all.begin(), all.end(), [](const ContactRow& a, const ContactRow& b) { return std::pair(a.i, a.j) < std::pair(b.i, b.j); });
    return all;
}

void internal_force_sum(EngineState& s, std::int64_t (&out)[3]) {
    // Grains get what walls give; what walls got is the opposite of that.
    Wide sum[3] = {};
    for (const Tile& tile : s.sub.tiles)
        for (std::uint32_t k = 0; k < tile.count; ++k)
            for (int c = 0; c < 3; ++c) sum[c] += tile.sums[k].force[c];
    for (const core::WallSum& w : s.sub.wall_last)
        for (int c = 0; c < 3; ++c) sum[c] += w.force[c];
    s.comm->sum(sum, 3);
    for (int c = 0; c < 3; ++c) out[c] = static_cast<std::int64_t>(sum[c]);
}

} // namespace talus::runtime
