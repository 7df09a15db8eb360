// Materials, walls, laws, and grains in and out.
#include <algorithm>
#include <array>
#include <cmath>

#include "runtime/comm/packing_buffer.hpp"
#include "runtime/engine.hpp"
#include "runtime/large_array.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::ErrorKind;
using core::fail;
using core::Label;
using core::LocalIndex;
using core::Particle;

int Engine::add_material(const core::Material& m) {
    require_healthy();
    Model& model = state_->model;
    if (model.units_fixed) fail(ErrorKind::state, "materials are added before the first step: the unit of force sums is fixed then");
    if (model.materials.size() == core::kMaxMaterials) fail(ErrorKind::capacity, "there are {} materials already, the most possible", core::kMaxMaterials);
    if (!m.rigid) {
        if (!(m.young > 0.0) || !std::isfinite(m.young)) fail(ErrorKind::argument, "young = {}: must be > 0 [Pa]", m.young);
        if (!(m.poisson >= 0.0) || !(m.poisson < 0.5)) fail(ErrorKind::argument, "poisson = {}: must be in [0, 0.5)", m.poisson);
        if (!(m.density > 0.0) || !std::isfinite(m.density)) fail(ErrorKind::argument, "density = {}: must be > 0 [kg/m^3]", m.density);
    }
    model.materials.push_back(m);
    setup_stale_ = true;
    return static_cast<int>(model.materials.size()) - 1;
}

void Engine::set_contact(int a, int b, const core::ContactMaterial& c) {
    require_healthy();
    Model& model = state_->model;
    const int n = static_cast<int>(model.materials.size());
    if (a < 0 || a >= n || b < 0 || b >= n) fail(ErrorKind::argument, "materials {} and {}: there are materials 0 to {}", a, b, n - 1);
    if (!(c.restitution >= 0.05) || !(c.restitution <= 1.0)) fail(ErrorKind::argument, "restitution = {}: must be in [0.05, 1]", c.restitution);
    if (!(c.friction >= 0.0) || !std::isfinite(c.friction)) fail(ErrorKind::argument, "friction = {}: must be >= 0", c.friction);
    if (!(c.rolling_friction >= 0.0) || !std::isfinite(c.rolling_friction)) fail(ErrorKind::argument, "rolling_friction = {}: must be >= 0", c.rolling_friction);
    model.contacts[a][b] = c;
    model.contacts[a][b].is_set = true;
    model.contacts[b][a] = model.contacts[a][b];
    setup_stale_ = true;
}

int Engine::add_wall(const core::WallPlane& plane) {
    require_healthy();
    Model& model = state_->model;
    if (model.units_fixed) fail(ErrorKind::state, "walls are added before the first step");
    if (model.walls.size() == core::kMaxWalls) fail(ErrorKind::capacity, "there are {} walls already, the most possible", core::kMaxWalls);
    const int n = static_cast<int>(model.materials.size());
    if (plane.material < 0 || plane.material >= n) fail(ErrorKind::argument, "wall material {}: there are materials 0 to {}", plane.material, n - 1);
    Wall w;
    w.plane = plane;
    const double length = std::sqrt(core::dot(plane.normal, plane.normal));
    const double sum = plane.point.x + plane.point.y + plane.point.z + plane.velocity.x + plane.velocity.y + plane.velocity.z;
    if (!(length > 0.0) || !std::isfinite(length) || !std::isfinite(sum)) fail(ErrorKind::argument, "wall: normal {} {} {}, point {} {} {}, velocity {} {} {}: all must be finite and the normal longer than zero", plane.normal.x, plane.normal.y, plane.normal.z, plane.point.x, plane.point.y, plane.point.z, plane.velocity.x, plane.velocity.y, plane.velocity.z);
    w.plane.normal = plane.normal * (1.0 / length);
    const double along[3] = {w.plane.normal.x, w.plane.normal.y, w.plane.normal.z};
    for (int a = 0; a < 3; ++a)
        if (model.settings.domain.periodic[a] && along[a] != 0.0) fail(ErrorKind::argument, "a wall with a normal along the periodic axis {} would cut its own images", "xyz"[a]);
    model.walls.push_back(w);
    lists_stale_ = true;
    setup_stale_ = true;
    return static_cast<int>(model.walls.size()) - 1;
}

void Engine::set_wall_velocity(int wall, const double (&v)[3]) {
    require_healthy();
    Model& model = state_->model;
    if (wall < 0 || wall >= static_cast<int>(model.walls.size())) fail(ErrorKind::argument, "wall {}: there are walls 0 to {}", wall, static_cast<int>(model.walls.size()) - 1);
    if (!std::isfinite(v[0] + v[1] + v[2])) fail(ErrorKind::argument, "wall velocity {} {} {}: not finite", v[0], v[1], v[2]);
    fold_wall_work();
    model.walls[static_cast<std::size_t>(wall)].plane.velocity = {v[0], v[1], v[2]};
    verdict_stale_ = true;
}

void Engine::set_laws(const core::Laws& laws) {
    require_healthy();
    EngineState& s = *state_;
    if (const std::string faults = laws_faults(laws); !faults.empty()) fail(ErrorKind::argument, "{}", faults);
    core::Laws& now = s.model.settings.laws;
    if (s.model.units_fixed && laws.normal != now.normal) fail(ErrorKind::state, "the normal law is chosen before the first step: the unit of force sums follows from it");
    if (s.model.units_fixed && laws.normal == core::NormalLaw::linear) {
        const double most = core::most_force(s.model.units, s.model.radius_max, s.model.settings.domain.extent()) / s.model.radius_max;
        if (laws.stiffness_n > most) fail(ErrorKind::state, "stiffness_n = {}: the unit of force sums, made at the first step, has room for at most {} N/m; begin with the largest stiffness that is to come", laws.stiffness_n, most);
    }
    if (laws.tangential != now.tangential || laws.rolling != now.rolling || laws.normal != now.normal) {
        // The rows mean something else now: every contact starts anew, with the touching bits kept.
        const int doubles = core::history_doubles(laws);
        for (core::Tile& t : s.sub.tiles) t.void_histories(doubles);
        s.sub.contacts.void_histories(doubles);
    }
    now = laws;
    setup_stale_ = true;
}

void Engine::set_time_step(double dt) {
    require_healthy();
    if (!(dt > 0.0) || !std::isfinite(dt)) fail(ErrorKind::argument, "time_step = {}: must be > 0 [s]", dt);
    fold_wall_work();
    state_->model.settings.time_step = dt;
    setup_stale_ = true;
    expect_motion();
}

void Engine::set_gravity(const double (&g)[3]) {
    require_healthy();
    if (!std::isfinite(g[0] + g[1] + g[2])) fail(ErrorKind::argument, "gravity {} {} {}: not finite", g[0], g[1], g[2]);
    for (int a = 0; a < 3; ++a) state_->model.settings.gravity[a] = g[a];
    setup_stale_ = true;
}

void Engine::set_group(int group, const core::GroupMotion& motion) {
    require_healthy();
    if (group < 0 || group >= core::kMaxGroups) fail(ErrorKind::argument, "group {}: there are groups 0 to {}", group, core::kMaxGroups - 1);
    const int mode = static_cast<int>(motion.mode);
    double sum = 0.0;
    for (int a = 0; a < 3; ++a) sum += motion.velocity[a] + motion.angular_velocity[a];
    if (!std::isfinite(sum)) fail(ErrorKind::argument, "group {}: velocity {} {} {}, angular velocity {} {} {}: not finite", group, motion.velocity[0], motion.velocity[1], motion.velocity[2], motion.angular_velocity[0], motion.angular_velocity[1], motion.angular_velocity[2]);
    if (mode < 0 || mode > 2) fail(ErrorKind::argument, "group mode {}: not one of TALUS_GROUP_*", mode);
    state_->model.groups[static_cast<std::size_t>(group)] = motion;
    setup_stale_ = true;
    expect_motion();
}

void Engine::check_labels(const std::vector<NewGrain>& grains) {
    // A label's keeper sees all that are or would be: label modulo ranks.
    EngineState& s = *state_;
    std::vector<Packer> packers(static_cast<std::size_t>(s.comm->size()));
    const auto put = [&](Label label) { packers[static_cast<std::size_t>(label % s.comm->size())].put(label); };
    for (const NewGrain& g : grains) put(g.label);
    for (LocalIndex i = 0; i < s.sub.n_owned; ++i) put(s.sub.particles[i].label);
    std::vector<Parcel> parcels;
    for (int r = 0; r < s.comm->size(); ++r)
        if (!packers[static_cast<std::size_t>(r)].empty()) parcels.push_back({r, packers[static_cast<std::size_t>(r)].take()});
    std::vector<Label> labels;
    for (const Parcel& p : s.comm->sparse_exchange(std::move(parcels))) {
        Unpacker u(p.data);
        while (!u.done()) labels.push_back(u.get<Label>());
    }
    std::sort(labels.begin(), labels.end());
    agree(*s.comm, [&] {
        const auto twice = std::adjacent_find(labels.begin(), labels.end());
        if (twice != labels.end()) fail(ErrorKind::argument, "label {} is given twice; labels name a grain for ever and are unique over all ranks", *twice);
    });
}

void Engine::note_radii(const std::vector<NewGrain>& grains) {
    EngineState& s = *state_;
    double largest = 0.0, smallest = HUGE_VAL;
    for (const NewGrain& g : grains) {
        largest = std::max(largest, g.radius);
        smallest = std::min(smallest, g.radius);
    }
    largest = s.comm->max(largest);
    smallest = s.comm->min(smallest);
    Model& m = s.model;
    const double declared = m.settings.radius_max;
    if (declared > 0.0 && largest > declared) fail(ErrorKind::argument, "a grain of radius {} m is above settings.radius_max = {} m", largest, declared);
    if (m.units_fixed && largest > m.radius_max) fail(ErrorKind::state, "a grain of radius {} m is above the largest one at the first step, {} m, from which the unit of force sums was made; declare settings.radius_max when larger grains come later", largest, m.radius_max);
    if (m.units_fixed && smallest < m.radius_min && 4.0 * std::pow(1.0 + m.radius_max / smallest, 2) + core::kMaxWalls > core::kMaxContributions)
        fail(ErrorKind::capacity, "a grain of radius {} m beside grains of {} m: a size ratio above 44 could overflow force sums", smallest, m.radius_max);
    m.radius_max = std::max({m.radius_max, largest, declared});
    m.radius_min = m.radius_min > 0.0 ? std::min(m.radius_min, smallest) : smallest;
}

void Engine::append(const std::vector<NewGrain>& grains) {
    EngineState& s = *state_;
    empty_tiles(s, true);
    Subdomain& sub = s.sub;
    make_large_room(sub.particles, sub.particles.size() + grains.size());
    make_large_room(sub.references, sub.references.size() + grains.size());
    for (const NewGrain& g : grains) {
        Particle p{};
        for (int a = 0; a < 3; ++a) {
            p.position[a] = g.position[a];
            p.velocity[a] = g.velocity[a];
            p.angular_velocity[a] = g.angular_velocity[a];
        }
        p.radius = g.radius;
        p.mass = s.model.materials[static_cast<std::size_t>(g.material)].density * (4.0 / 3.0 * core::kPi) * (g.radius * g.radius * g.radius);
        p.meta = core::make_meta(g.material, g.group, g.colour) | core::kNewGrain;
        p.label = g.label;
        sub.particles.push_back(p);
        core::Reference reference{p.position[0], p.position[1], p.position[2]};
        core::wrap(s.model.settings.domain, sub.particles.back().position, reference);
        sub.references.push_back(reference);
        sub.sums.push_back(core::ForceSum{});
        sub.slot_of.push_back(sub.contacts.append(nullptr, nullptr, 0));
    }
    sub.n_owned = static_cast<LocalIndex>(sub.particles.size());
    s.model.n_particles = s.comm->sum(static_cast<std::int64_t>(sub.n_owned));
    // Tiles are gone until the lists are refreshed; what empty_tiles laid out waits in the subdomain.
}

void Engine::insert(const std::vector<NewGrain>& grains, double max_overlap) {
    require_healthy();
    EngineState& s = *state_;
    const core::Domain& d = s.model.settings.domain;
    agree(*s.comm, [&] {
        if (!(max_overlap >= 0.0) || !(max_overlap <= 1.0)) fail(ErrorKind::argument, "max_overlap = {}: must be in [0, 1], a share of the smaller radius", max_overlap);
        for (const NewGrain& g : grains) {
            if (g.label < 0 || g.label >= core::kWallLabel) fail(ErrorKind::argument, "label {}: must be in [0, 2^62)", g.label);
            if (!(g.radius > 0.0) || !std::isfinite(g.radius)) fail(ErrorKind::argument, "grain {}: radius {} must be > 0 [m]", g.label, g.radius);
            double sum = 0.0;
            for (int a = 0; a < 3; ++a) sum += g.velocity[a] + g.angular_velocity[a] + g.position[a];
            if (!std::isfinite(sum)) fail(ErrorKind::argument, "grain {}: position {} {} {}, velocity {} {} {}: not finite", g.label, g.position[0], g.position[1], g.position[2], g.velocity[0], g.velocity[1], g.velocity[2]);
            for (int a = 0; a < 3; ++a)
                if (g.position[a] < d.lo[a] || g.position[a] > d.hi[a]) fail(ErrorKind::argument, "grain {} at {} {} {} lies outside the domain on axis {} ({} to {})", g.label, g.position[0], g.position[1], g.position[2], "xyz"[a], d.lo[a], d.hi[a]);
            const int n = static_cast<int>(s.model.materials.size());
            if (g.material < 0 || g.material >= n) fail(ErrorKind::argument, "grain {}: material {}, but there are materials 0 to {}", g.label, g.material, n - 1);
            if (s.model.materials[static_cast<std::size_t>(g.material)].rigid) fail(ErrorKind::argument, "grain {}: material {} is rigid; rigid is for walls", g.label, g.material);
            if (g.group < 0 || g.group >= core::kMaxGroups) fail(ErrorKind::argument, "grain {}: group {} must be in 0 to {}", g.label, g.group, core::kMaxGroups - 1);
            if (g.colour < 0 || g.colour > 255) fail(ErrorKind::argument, "grain {}: colour {} must be in 0 to 255", g.label, g.colour);
        }
    });
    check_labels(grains);
    const double radius_max = s.model.radius_max, radius_min = s.model.radius_min;
    note_radii(grains);
    // New grains carry a mark, so that the checks below tell them from old ones wherever they went.
    append(grains);
    try {
        refresh_lists();
        check_overlaps(max_overlap);
    } catch (const core::Error&) {
        if (poisoned_) throw;
        s.model.radius_max = radius_max;
        s.model.radius_min = radius_min;
        remove_unless([](const Particle& p) { return !core::is_new(p); });
        throw;
    }
    for (Particle& p : s.sub.particles) p.meta &= ~core::kNewGrain; // ghosts too
    setup_stale_ = true; // checks run again before the next step, on all grains
    forces_stale_ = true;
    ++generation_;
}

void Engine::check_overlaps(double max_overlap) {
    EngineState& s = *state_;
    const core::Periods periods(s.model.settings.domain);
    agree(*s.comm, [&] {
        for (const core::Tile& tile : s.sub.tiles) {
            tile.pairs.each_pair([&](core::CandidatePair pair) {
                const Particle &a = s.sub.particles[tile.index_of[pair.i]], &b = s.sub.particles[tile.index_of[pair.j]];
                const core::Vec3d d = core::minimum_image(periods, core::make_vec3(a.position) - core::make_vec3(b.position));
                const double overlap = a.radius + b.radius - std::sqrt(core::dot(d, d)), least = std::min(a.radius, b.radius);
                if ((core::is_new(a) || core::is_new(b)) && overlap > max_overlap * least)
                    fail(ErrorKind::argument, "grains {} and {} overlap by {} m, {:.3g} of the smaller radius {} m; at most {} of it is allowed", std::min(a.label, b.label), std::max(a.label, b.label), overlap, overlap / least, least, max_overlap);
            });
            for (std::size_t w = 0; w < tile.walls.size(); ++w)
                tile.walls[w].each_pair([&](core::CandidatePair pair) {
                    const Particle& p = s.sub.particles[tile.index_of[pair.i]];
                    const core::WallPlane& plane = s.model.walls[w].plane;
                    const double overlap = p.radius - core::dot(core::make_vec3(p.position) - plane.point, plane.normal);
                    if (core::is_new(p) && overlap > max_overlap * p.radius)
                        fail(ErrorKind::argument, "grain {} reaches {} m into wall {}, {:.3g} of its radius {} m; at most {} of it is allowed", p.label, overlap, w, overlap / p.radius, p.radius, max_overlap);
                });
        }
    });
}

template <class Keep>
std::int64_t Engine::remove_unless(Keep keep) {
    EngineState& s = *state_;
    empty_tiles(s, true);
    Subdomain& sub = s.sub;
    const LocalIndex before = sub.n_owned;
    sub.keep_owned([&](LocalIndex i) { return keep(sub.particles[i]); });
    const std::int64_t removed = s.comm->sum(static_cast<std::int64_t>(before - sub.n_owned));
    s.model.n_particles -= removed;
    lists_stale_ = true;
    if (s.model.n_particles > 0) refresh_lists();
    return removed;
}

std::int64_t Engine::remove_above(int axis, double level) {
    require_healthy();
    require_same(*state_->comm, "axis and level", std::array{static_cast<double>(axis), level});
    if (axis < 0 || axis > 2) fail(ErrorKind::argument, "axis {}: must be 0, 1 or 2", axis);
    return take_out([&](const Particle& p) { return !(p.position[axis] > level); });
}

std::int64_t Engine::remove_box(const double (&lo)[3], const double (&hi)[3]) {
    require_healthy();
    require_same(*state_->comm, "lo", lo);
    require_same(*state_->comm, "hi", hi);
    return take_out([&](const Particle& p) {
        bool inside = true;
        for (int a = 0; a < 3; ++a) inside = inside && p.position[a] >= lo[a] && p.position[a] < hi[a];
        return !inside;
    });
}

std::int64_t Engine::remove_labels(const std::vector<Label>& mine) {
    require_healthy();
    EngineState& s = *state_;
    // All labels on all ranks: whoever holds a grain of them takes it out.
    std::vector<std::int64_t> counts(static_cast<std::size_t>(s.comm->size()));
    const auto n = static_cast<std::int64_t>(mine.size());
    s.comm->gather_all(&n, sizeof n, counts.data());
    const auto most = static_cast<std::size_t>(*std::max_element(counts.begin(), counts.end()));
    std::vector<Label> padded(mine), all(most * counts.size());
    padded.resize(most, mine.empty() ? Label{0} : mine.front());
    if (most > 0) s.comm->gather_all(padded.data(), most * sizeof(Label), all.data());
    std::vector<Label> wanted;
    for (std::size_t r = 0; r < counts.size(); ++r) wanted.insert(wanted.end(), all.begin() + static_cast<std::ptrdiff_t>(r * most), all.begin() + static_cast<std::ptrdiff_t>(r * most) + counts[r]);
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    std::vector<std::int64_t> found(wanted.size());
    for (LocalIndex i = 0; i < s.sub.n_owned; ++i) {
        const auto at = std::lower_bound(wanted.begin(), wanted.end(), s.sub.particles[i].label);
        if (at != wanted.end() && *at == s.sub.particles[i].label) found[static_cast<std::size_t>(at - wanted.begin())] = 1;
    }
    if (!found.empty()) s.comm->sum(found);
    if (const auto missing = std::find(found.begin(), found.end(), 0); missing != found.end())
        fail(ErrorKind::argument, "there is no grain with label {} to remove ({} of {} labels are missing)", wanted[static_cast<std::size_t>(missing - found.begin())], std::count(found.begin(), found.end(), 0), wanted.size());
    return take_out([&](const Particle& p) { return !std::binary_search(wanted.begin(), wanted.end(), p.label); });
}

template <class Keep>
std::int64_t Engine::take_out(Keep keep) {
    const std::int64_t removed = remove_unless(keep);
    forces_stale_ = forces_stale_ || removed > 0;
    ++generation_;
    return removed;
}

std::int64_t Engine::fill(core::FillPlan plan, std::int64_t count, Label first_label, int material, int group) {
    require_healthy();
    EngineState& s = *state_;
    const Settings& set = s.model.settings;
    std::vector<double> given{plan.radius_min, plan.radius_max, plan.room, plan.jitter, static_cast<double>(count), static_cast<double>(first_label), static_cast<double>(material), static_cast<double>(group)};
    for (int a = 0; a < 3; ++a) {
        given.push_back(plan.lo[a]);
        given.push_back(plan.hi[a]);
    }
    require_same(*s.comm, "fill", given);
    if (!(plan.radius_min > 0.0) || !(plan.radius_max >= plan.radius_min) || !std::isfinite(plan.radius_max)) fail(ErrorKind::argument, "fill radii {} to {}: must be 0 < radius_min <= radius_max [m]", plan.radius_min, plan.radius_max);
    if (!(plan.room >= 0.0) || !(plan.jitter >= 0.0) || !(plan.jitter <= 1.0)) fail(ErrorKind::argument, "fill room = {}, jitter = {}: room must be >= 0 and jitter in [0, 1]", plan.room, plan.jitter);
    for (int a = 0; a < 3; ++a)
        if (!(plan.lo[a] < plan.hi[a]) || plan.lo[a] < set.domain.lo[a] || plan.hi[a] > set.domain.hi[a]) fail(ErrorKind::argument, "fill box along {}: {} to {} m must lie within the domain, {} to {} m", "xyz"[a], plan.lo[a], plan.hi[a], set.domain.lo[a], set.domain.hi[a]);
    plan.seed = set.seed;
    plan.layer_axis = 0;
    for (int a = 1; a < 3; ++a)
        if (std::fabs(set.gravity[a]) > std::fabs(set.gravity[plan.layer_axis])) plan.layer_axis = a;
    plan.layers_down = set.gravity[plan.layer_axis] > 0.0;
    core::plan_lattice(plan);
    std::int64_t n = plan.n_places();
    if (n == 0) fail(ErrorKind::argument, "the fill box holds no grain of radius {} m", plan.radius_max);
    if (count > 0) {
        if (count > n) fail(ErrorKind::argument, "{} grains asked for, but the fill box has {} places; make it higher or the room smaller", count, n);
        n = count;
    }
    const std::int64_t from = n * s.comm->rank() / s.comm->size(), to = n * (s.comm->rank() + 1) / s.comm->size();
    std::vector<NewGrain> grains;
    grains.reserve(static_cast<std::size_t>(to - from));
    for (std::int64_t place = from; place < to; ++place) {
        const core::FilledGrain f = core::grain_at(plan, place);
        NewGrain g{};
        g.label = first_label + place;
        for (int a = 0; a < 3; ++a) g.position[a] = f.position[a];
        g.radius = f.radius;
        g.material = material;
        g.group = group;
        grains.push_back(g);
    }
    insert(grains, 0.0);
    return n;
}

void Engine::add_velocity(const double (&v)[3]) {
    require_healthy();
    EngineState& s = *state_;
    require_same(*s.comm, "velocity", v);
    if (!std::isfinite(v[0] + v[1] + v[2])) fail(ErrorKind::argument, "velocity {} {} {}: not finite", v[0], v[1], v[2]);
    for (LocalIndex i = 0; i < s.sub.n_owned; ++i) {
        Particle& p = s.sub.particles[i];
        if (s.model.groups[static_cast<std::size_t>(core::group_of(p))].mode != core::GroupMotion::Mode::free) continue;
        for (int a = 0; a < 3; ++a) p.velocity[a] += v[a];
    }
    lists_stale_ = true; // ghosts must show the new velocities
    ++generation_;
}

void Engine::stop_grains() {
    require_healthy();
    EngineState& s = *state_;
    for (LocalIndex i = 0; i < s.sub.n_owned; ++i) {
        Particle& p = s.sub.particles[i];
        if (s.model.groups[static_cast<std::size_t>(core::group_of(p))].mode != core::GroupMotion::Mode::free) continue;
        for (int a = 0; a < 3; ++a) p.velocity[a] = p.angular_velocity[a] = 0.0;
    }
    lists_stale_ = true;
    ++generation_;
}

void Engine::colour_layers(int axis, double origin, double thickness) {
    require_healthy();
    require_same(*state_->comm, "axis, origin and thickness", std::array{static_cast<double>(axis), origin, thickness});
    if (axis < 0 || axis > 2) fail(ErrorKind::argument, "axis {}: must be 0, 1 or 2", axis);
    if (!(thickness > 0.0) || !std::isfinite(origin)) fail(ErrorKind::argument, "layers of {} m from {} m: the thickness must be > 0 and the origin finite", thickness, origin);
    EngineState& s = *state_;
    for (LocalIndex i = 0; i < s.sub.n_owned; ++i) {
        Particle& p = s.sub.particles[i];
        const double layer = std::floor((p.position[axis] - origin) / thickness);
        const int colour = static_cast<int>(layer - 256.0 * std::floor(layer / 256.0));
        p.meta = core::make_meta(core::material_of(p), core::group_of(p), colour);
    }
    // Ghosts keep their colours until the next lists: nobody reads them.
    ++generation_;
}

void Engine::mark_reference() {
    require_healthy();
    Subdomain& sub = state_->sub;
    for (LocalIndex i = 0; i < sub.n_owned; ++i)
        for (int a = 0; a < 3; ++a) sub.references[i][a] = sub.particles[i].position[a];
}

} // namespace talus::runtime
