#include "plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "config_keys.hpp"

namespace talus::sandbox {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kStepLimit = 0.5;            // of the Rayleigh step; the engine's own limit
constexpr double kLinearStepsPerContact = 20; // linear law: steps in the duration of a contact, by default
constexpr double kLeastStepsPerContact = 8;   // ... and at least
constexpr double kMostGrainsPerRank = 2e9;    // local indexes have 32 bits
constexpr double kMostSnapshots = 9999;       // run_NNNN.hdf
constexpr double kWedgeSlope = 0.14;          // tan 8 degrees: steeper than any critical taper of dry sand on this floor
constexpr double kLevelSurplus = 1.04;        // of sand, with [box] level
constexpr double kDefaultDistance = 0.5;      // of the length: the paper's 5 s at 0.1 m/s in 1 m
constexpr double kDefaultSnapshot = 0.002;    // [m]

// Rayleigh step of a grain (physics: Li et al.).
double rayleigh_step(double radius, const Config::Sand& sand) {
    const double shear = sand.young / (2 * (1 + sand.poisson));
    return kPi * radius * std::sqrt(sand.density / shear) / (0.1631 * sand.poisson + 0.8766);
}

// Duration of a contact of two smallest grains in the linear law, without damping.
double linear_contact_time(double radius, double density, double stiffness) {
    const double mass = density * 4 * kPi / 3 * radius * radius * radius;
    return kPi * std::sqrt(0.5 * mass / stiffness);
}

class Planner {
public:
    Planner(const Config& config, const std::optional<BedSummary>& bed, std::optional<std::int64_t> steps, int ranks, Faults& faults)
        : c_(config), bed_(bed), steps_(steps), ranks_(ranks), faults_(faults) {}

    Plan make() {
        // A bed file that could not be read leaves nothing to conclude from.
        const bool has_geometry = c_.bed.file.empty() || bed_.has_value();
        exclusive_keys();
        words();
        if (!has_geometry) return plan_;
        if (bed_)
            geometry_of_bed();
        else
            geometry_of_fill();
        time_step();
        motion();
        height();
        periodic_length();
        engine();
        snapshots();
        return plan_;
    }

private:
    const Config& c_;
    const std::optional<BedSummary>& bed_;
    std::optional<std::int64_t> steps_;
    int ranks_;
    Faults& faults_;
    Plan plan_;

    // A fault of the first key, unless one of the keys it follows from was refused already.
    void fault(std::initializer_list<const char*> keys, const std::string& text) {
        for (const char* key : keys)
            if (c_.refused.count(key) != 0) return;
        const std::string first = *keys.begin();
        faults_.add(fmt::format("{}: {}: {}", where(c_, first), subject(c_, first), text));
    }
    void only_one(const char* first, const char* second) {
        if (c_.is_given(first) && c_.is_given(second))
            fault({first, second}, fmt::format("{} is given too; give one of them", subject(c_, second)));
    }

    void exclusive_keys() {
        only_one("time.step", "time.step_fraction");
        only_one("shorten.distance", "shorten.duration");
        only_one("run.snapshot_shortening", "run.snapshot_time");
        if (c_.is_given("shorten.ramp") && c_.shorten.start != kStartRamp)
            fault({"shorten.ramp", "shorten.start"}, fmt::format("{} has no ramp; remove one of them", subject(c_, "shorten.start")));
        if (c_.bed.file.empty()) return;
        for (const char* key : {"sand.diameter_mean", "sand.diameter_half_width", "box.length", "box.depth", "box.width",
                                "box.solid_fraction", "box.fill_room", "box.level"})
            if (c_.is_given(key)) fault({key}, fmt::format("is told by the bed file ({}); remove this key or bed.file", c_.bed.file));
    }

    void words() {
        std::string axes = c_.bed.axes;
        std::sort(axes.begin(), axes.end());
        if (axes != "xyz") fault({"bed.axes"}, "must name x, y and z once each, as in \"xzy\" for a file with z up");
        if (c_.laws.normal == TALUS_NORMAL_LINEAR && !c_.laws.stiffness_n)
            fault({"laws.stiffness_n", "laws.normal"}, "the linear law needs it; give a number above 0 N/m");
        if (c_.laws.normal != TALUS_NORMAL_LINEAR)
            for (const char* key : {"laws.stiffness_n", "laws.stiffness_t"})
                if (c_.is_given(key)) fault({key, "laws.normal"}, "belongs to the linear law; set laws.normal = \"linear\" or remove it");
        if (c_.laws.rolling_radius == TALUS_ROLLING_RADIUS_OWN && c_.laws.rolling == TALUS_ROLLING_SPRING)
            fault({"laws.rolling_radius", "laws.rolling"}, "goes with rolling = \"constant\" only; use \"effective\"");
        if (c_.walls.rigid)
            for (const char* key : {"walls.young", "walls.poisson"})
                if (c_.is_given(key)) fault({key, "walls.rigid"}, "means nothing for rigid walls; remove it or walls.rigid");
    }

    // What the box must have room for: an automatic skin keeps to the room there is, but a tenth of the diameter is required.
    double skin() const { return c_.engine.skin > 0 ? c_.engine.skin : 0.2 * plan_.radius_max; }

    void geometry_of_bed() {
        plan_.has_bed_file = true;
        plan_.grains = bed_->count;
        plan_.radius_min = bed_->radius_min;
        plan_.radius_max = bed_->radius_max;
        plan_.grain_volume = bed_->volume / static_cast<double>(bed_->count);
        plan_.grain_mass = plan_.grain_volume * c_.sand.density;
        plan_.lo = bed_->lo;
        plan_.hi = bed_->hi;
        plan_.depth = bed_->top - bed_->lo[1];
        plan_.skin = skin();
    }

    void geometry_of_fill() {
        const Config::Sand& sand = c_.sand;
        if (sand.diameter_half_width >= sand.diameter_mean)
            return fault({"sand.diameter_half_width", "sand.diameter_mean"},
                         fmt::format("is not below diameter_mean = {:g} m: the smallest grain would have no size; "
                                     "the paper has a tenth of the mean",
                                     sand.diameter_mean));
        const double a = plan_.radius_min = 0.5 * (sand.diameter_mean - sand.diameter_half_width);
        const double b = plan_.radius_max = 0.5 * (sand.diameter_mean + sand.diameter_half_width);
        // The mean of r^3 over a uniform distribution from a to b is (a + b)(a^2 + b^2)/4.
        plan_.grain_volume = 4 * kPi / 3 * (a + b) * (a * a + b * b) / 4;
        plan_.grain_mass = plan_.grain_volume * sand.density;
        plan_.skin = skin();
        plan_.hi = {c_.box.length, 0, c_.box.width};
        plan_.depth = c_.box.depth;

        // What is to be levelled must stick out first.
        const double depth = c_.box.depth * (c_.box.level ? kLevelSurplus : 1);
        const double volume = c_.box.length * depth * c_.box.width;
        const double grains = std::floor(c_.box.solid_fraction * volume / plan_.grain_volume);
        for (const auto& [key, size] : {std::pair{"box.length", c_.box.length}, {"box.depth", c_.box.depth}, {"box.width", c_.box.width}})
            if (size < 2 * b)
                fault({key, "sand.diameter_mean", "sand.diameter_half_width"},
                      fmt::format("holds zero grains of up to {:g} m; make it larger or the grains smaller", 2 * b));
        if (grains > 1e15)
            return fault({"sand.diameter_mean", "box.length", "box.depth", "box.width"},
                         fmt::format("would need {:g} grains; check the units: lengths are in m", grains));
        plan_.grains = static_cast<std::int64_t>(grains);
        if (plan_.grains < 1) return;

        // The lattice of the fill, as talus_fill lays it.
        const double spacing = 2 * b * (1 + c_.box.fill_room);
        const double in_layer = std::max(1.0, std::floor(c_.box.length / spacing)) * std::max(1.0, std::floor(c_.box.width / spacing));
        plan_.fill_top = std::ceil(grains / in_layer) * spacing;
        plan_.fall_time = std::sqrt(2 * plan_.fill_top / c_.box.gravity);
    }

    void time_step() {
        if (plan_.radius_min <= 0) return;
        plan_.critical_step = rayleigh_step(plan_.radius_min, c_.sand);
        plan_.step = c_.time.step.value_or(c_.time.step_fraction * plan_.critical_step);
        const char* smallest = bed_ ? "bed.file" : "sand.diameter_mean";
        if (plan_.step > kStepLimit * plan_.critical_step)
            fault({"time.step", smallest, "sand.young", "sand.density"},
                  fmt::format("is {:.3g} of the Rayleigh step {:.4g} s of the smallest grain; stay below {:g} of it, "
                              "best at 0.1 to 0.2 ({:.3g} to {:.3g} s)",
                              plan_.step / plan_.critical_step, plan_.critical_step, kStepLimit, 0.1 * plan_.critical_step,
                              0.2 * plan_.critical_step));
        if (c_.laws.normal != TALUS_NORMAL_LINEAR || !c_.laws.stiffness_n) return;
        const double contact = linear_contact_time(plan_.radius_min, c_.sand.density, *c_.laws.stiffness_n);
        if (!c_.time.step)
            plan_.step = std::min(plan_.step, contact / kLinearStepsPerContact);
        else if (plan_.step > contact / kLeastStepsPerContact)
            fault({"time.step", "laws.stiffness_n", smallest},
                  fmt::format("a contact of the linear law lasts {:.4g} s; stay below an eighth of it, best at {:.3g} s", contact,
                              contact / kLinearStepsPerContact));
    }

    void motion() {
        if (!(plan_.step > 0)) return;
        const Config::Shorten& s = c_.shorten;
        // A floor of little friction carries little; but a ramp must end, so it counts as at least this.
        constexpr double kLeastCarrying = 0.05;
        const double carrying = std::max(c_.walls.floor_friction, kLeastCarrying) * c_.box.gravity;
        const double ramp = s.start != kStartRamp ? 0 : s.ramp.value_or(3 * s.speed / carrying);
        plan_.shortening = Shortening(s.speed, ramp, plan_.step);

        const double distance = s.distance.value_or(kDefaultDistance * plan_.length());
        const double steps_wanted = (s.duration ? *s.duration : distance / s.speed + ramp) / plan_.step;
        const char* goal = s.duration ? "shorten.duration" : "shorten.distance";
        if (steps_wanted > 1e15)
            return fault({goal, "shorten.speed", "time.step"},
                         fmt::format("would take {:g} steps; check the units: m, s and m/s", steps_wanted));
        if (steps_)
            plan_.shorten_steps = *steps_;
        else if (s.duration)
            plan_.shorten_steps = static_cast<std::int64_t>(std::ceil(*s.duration / plan_.step));
        else
            plan_.shorten_steps = plan_.shortening.steps_for(distance);

        const double travel = plan_.shortening.travel(plan_.shorten_steps);
        const double most = 0.9 * plan_.length();
        if (travel <= most) return;
        const std::string problem =
            fmt::format("the front wall would go {:.4g} m in a box {:g} m long; let it go {:.4g} m at most", travel, plan_.length(), most);
        if (steps_)
            faults_.add(fmt::format("--steps {}: {}", *steps_, problem));
        else
            fault({goal, "box.length", "shorten.speed"}, problem);
    }

    void height() {
        const double diameter = 2 * plan_.radius_max;
        if (plan_.grains < 1 || !(diameter > 0)) return;
        const double depth = plan_.depth;
        // Sand keeps its volume: its mean depth grows as the box gets shorter, and it stands higher at the back stop.
        const double left = std::max(0.1 * plan_.length(), plan_.length() - plan_.shortening.travel(plan_.shorten_steps));
        const double wedge = depth * plan_.length() / left + 0.5 * kWedgeSlope * left;
        const double needed = std::max(bed_ ? depth + diameter : plan_.fill_top, wedge) + 4 * diameter;
        double height = std::max(needed, 4 * depth);
        if (bed_) height = std::max(height, bed_->hi[1] - bed_->lo[1]);
        if (c_.box.height && *c_.box.height < needed)
            fault({"box.height", "box.depth", "box.length", "box.width", "shorten.distance", "shorten.duration"},
                  fmt::format("the {} needs {:.4g} m; leave the key out to have {:.4g} m",
                              bed_ || wedge > plan_.fill_top ? "sand, pushed up," : "loose fill", needed, height));
        plan_.hi[1] = plan_.lo[1] + c_.box.height.value_or(height);
    }

    void periodic_length() {
        if (!c_.box.periodic_z || plan_.radius_max <= 0) return;
        const double least = 2 * (2 * plan_.radius_max + plan_.skin);
        if (plan_.width() >= least) return;
        const std::string problem =
            fmt::format("a periodic length must be at least 2 (largest diameter + skin) = {:.6g} m, so that no two grains meet twice; "
                        "make the box wider or engine.skin smaller than {:.3g} m",
                        least, plan_.skin);
        if (bed_)
            fault({"bed.file", "engine.skin"}, fmt::format("its width is {:.6g} m; {}", plan_.width(), problem));
        else
            fault({"box.width", "engine.skin", "sand.diameter_mean", "sand.diameter_half_width"}, problem);
    }

    void engine() {
        if (c_.engine.skin > 4 * plan_.radius_max && plan_.radius_max > 0)
            fault({"engine.skin", "sand.diameter_mean"},
                  fmt::format("is larger than two grains; a twentieth to a fifth of the diameter ({:.2g} to {:.2g} m) is fast",
                              0.1 * plan_.radius_max, 0.4 * plan_.radius_max));
        if (ranks_ < 1 || plan_.grains < 1) return;
        const auto& grid = c_.engine.rank_grid;
        const std::int64_t product = grid[0] * grid[1] * grid[2];
        if (product != 0 && product != ranks_)
            fault({"engine.rank_grid"}, fmt::format("is for {} ranks, this run has {}; give three numbers with the "
                                                    "product {} or leave the key out",
                                                    product, ranks_, ranks_));
        // A subdomain narrower than what a grain reaches would need ghosts from beyond its neighbour.
        const double reach = 2 * plan_.radius_max + plan_.skin;
        double most = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const double room = std::max(1.0, std::floor((plan_.hi[axis] - plan_.lo[axis]) / reach));
            most *= room;
            if (static_cast<double>(grid[axis]) > room)
                fault({"engine.rank_grid"},
                      fmt::format("{} subdomains along {} are narrower than grain and skin, {:.3g} m; at most {:g} fit", grid[axis],
                                  "xyz"[axis], reach, room));
        }
        if (ranks_ > most)
            faults_.add(fmt::format("{}: {} ranks: subdomains would be narrower than grain and skin, {:.3g} m, and could "
                                    "not hold a halo; use at most {:g} ranks",
                                    c_.source, ranks_, reach, most));
        if (static_cast<double>(plan_.grains) / ranks_ > kMostGrainsPerRank)
            faults_.add(fmt::format("{}: {} grains on {} ranks: a rank holds at most {:g}; use {:g} ranks or more", c_.source, plan_.grains,
                                    ranks_, kMostGrainsPerRank, std::ceil(static_cast<double>(plan_.grains) / kMostGrainsPerRank)));
    }

    void snapshots() {
        plan_.snapshots_by_time = c_.run.snapshot_time.has_value();
        plan_.snapshot_every = plan_.snapshots_by_time ? *c_.run.snapshot_time : c_.run.snapshot_shortening.value_or(kDefaultSnapshot);
        const double span =
            plan_.snapshots_by_time ? static_cast<double>(plan_.shorten_steps) * plan_.step : plan_.shortening.travel(plan_.shorten_steps);
        const char* key = plan_.snapshots_by_time ? "run.snapshot_time" : "run.snapshot_shortening";
        if (span / plan_.snapshot_every > kMostSnapshots)
            fault({key, "shorten.distance", "shorten.duration", "shorten.speed"},
                  fmt::format("would write {:.0f} snapshots; at most {:g} have a name", span / plan_.snapshot_every, kMostSnapshots));
        if (c_.is_given(key) && plan_.shorten_steps > 0 && !steps_ && plan_.snapshot_every > span)
            fault({key, "shorten.distance", "shorten.duration", "shorten.speed"},
                  fmt::format("is more than the whole stage, {:.4g} {}; 2 mm are 0.002 m", span, plan_.snapshots_by_time ? "s" : "m"));
    }
};

} // namespace

std::int64_t Plan::snapshot_step(std::int64_t n) const {
    const double due = static_cast<double>(n) * snapshot_every;
    return snapshots_by_time ? static_cast<std::int64_t>(std::llround(due / step)) : shortening.steps_for(due);
}

std::int64_t Plan::settle_cap(const Config& config) const { return static_cast<std::int64_t>(std::ceil(config.settle.cap / step)); }

Plan make_plan(const Config& config, const std::optional<BedSummary>& bed, std::optional<std::int64_t> steps, int ranks, Faults& faults) {
    return Planner(config, bed, steps, ranks, faults).make();
}

std::string plan_text(const Config& config, const Plan& plan) {
    const double travel = plan.shortening.travel(plan.shorten_steps);
    std::string text =
        fmt::format("grains      {} of {:.4g} to {:.4g} mm\n"
                    "box         {:g} x {:.4g} x {:g} m (length, height, width{})\n"
                    "time step   {:.4g} s, {:.3g} of the Rayleigh step\n",
                    plan.grains, 2e3 * plan.radius_min, 2e3 * plan.radius_max, plan.length(), plan.hi[1] - plan.lo[1],
                    plan.width(), config.box.periodic_z ? ", periodic" : "", plan.step, plan.step / plan.critical_step);
    if (plan.has_bed_file)
        text += fmt::format("bed         {}\n", config.bed.file);
    else
        text += fmt::format("settling    from {:.3g} mm to {:.3g} mm, at most {:.3g} s or {} steps\n", 1e3 * plan.fill_top,
                            1e3 * config.box.depth, config.settle.cap, plan.settle_cap(config));
    text += fmt::format("shortening  {:.4g} mm at {:g} m/s after a ramp of {:.3g} s: {} steps, {:.3g} particle-steps\n", 1e3 * travel,
                        plan.shortening.speed(), plan.shortening.ramp(), plan.shorten_steps,
                        static_cast<double>(plan.shorten_steps) * static_cast<double>(plan.grains));
    return text;
}

} // namespace talus::sandbox
