#include "sample.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "settled_bed.hpp"
#include "stages.hpp"

namespace talus::sandbox {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kSampleGrains = 200e3; // a rank
constexpr double kColumnGrains = 8000;  // at most, but for kColumnWidth
constexpr double kColumnWork = 3e8;     // particle-steps that settling the column may take, roughly
constexpr double kColumnWidth = 6;      // largest diameters at least
constexpr double kColumnSeconds = 40;   // then settling is given up
constexpr double kDeepest = 500;        // diameters; a deeper bed is represented by its upper part
constexpr std::int64_t kRestSteps = 50; // timed together, so many times
constexpr std::size_t kRestTimes = 21;
constexpr double kFace = 3; // largest radii: thickness of the faces that are held

enum Group : std::int32_t { kFree, kFrontFace, kBackFace };

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

void step(const Scene& scene, std::int64_t steps) {
    const talus_status status = talus_engine_step(scene.engine.get(), steps, nullptr);
    scene.engine.check(status, "calibrating");
    if (status == TALUS_STOPPED) throw Failure(kExitStopped, "calibration was stopped; nothing is stored");
}

// The configuration of the column: that of the experiment, but narrow.
Config column_config(const Config& config, const Plan& plan) {
    Config column = config;
    const double diameter = 2 * plan.radius_max;
    column.box.depth = std::min(config.box.depth, kDeepest * diameter);
    // Settling takes a little more than the free fall, at least.
    const double grains = std::min(kColumnGrains, kColumnWork * plan.step / (1.3 * plan.fall_time));
    const double side = std::sqrt(grains * plan.grain_volume / (config.box.solid_fraction * column.box.depth));
    const double narrow = std::max(side, kColumnWidth * diameter);
    // A bed that is thinner than that is thin in the sample too, but for what a period must be.
    const double least = 2.02 * (diameter + plan.skin);
    column.box.width = std::max(std::min(narrow, config.box.width), config.box.periodic_z ? 0 : least);
    column.box.length = std::max(std::min(std::max(narrow, side * side / column.box.width), config.box.length), least);
    column.box.periodic_z = true;
    column.box.height.reset();
    column.shorten.distance.reset();
    column.shorten.duration.reset();
    column.run.snapshot_shortening.reset();
    column.run.snapshot_time.reset();
    column.engine.rank_grid = {0, 0, 0};
    return column;
}

std::vector<double> gather(const Scene& scene, std::int32_t field, std::int64_t grains, std::int64_t components) {
    std::vector<double> values(static_cast<std::size_t>(grains * components));
    std::int64_t count = 0;
    scene.engine.check(talus_particles_gather(scene.engine.get(), field, grains, values.data(), &count), "reading the column");
    return values;
}

// Fills and settles the column and takes its grains; on one rank and with one thread: it has few tiles to share.
Bed settle_column(const Config& config, const Plan& plan, Sample::Column& out_column) {
    const Team alone(MPI_COMM_SELF);
    const Scene scene = make_scene(alone, config, plan, 1);
    fill_box(scene, config, plan);
    prepare(scene, config);
    const Clock::time_point start = Clock::now();
    double stepping = 0;
    const std::int64_t cap = plan.settle_cap(config);
    Settling& settling = out_column.settling;
    settling.key = settling_key(config);
    while (settling.steps < cap && !settling.is_at_rest && seconds_since(start) < kColumnSeconds) {
        const std::int64_t steps = std::min(config.settle.check_every, cap - settling.steps);
        const Clock::time_point before = Clock::now();
        step(scene, steps);
        stepping += seconds_since(before);
        settling.steps += steps;
        if (static_cast<double>(settling.steps) * plan.step >= plan.fall_time)
            settling.is_at_rest = rest_of(config, plan, scene.engine.state()).is_reached;
    }
    const auto work = [&](std::int64_t steps) { return static_cast<double>(steps) * static_cast<double>(plan.grains); };
    out_column.speed = work(settling.steps) / stepping;
    std::vector<double> times;
    while (times.size() < kRestTimes) {
        const Clock::time_point before = Clock::now();
        step(scene, kRestSteps);
        times.push_back(seconds_since(before));
    }
    std::nth_element(times.begin(), times.begin() + kRestTimes / 2, times.end());
    out_column.speed_at_rest = work(kRestSteps) / times[kRestTimes / 2];

    Bed bed;
    bed.position = gather(scene, TALUS_FIELD_POSITION, plan.grains, 3);
    bed.radius = gather(scene, TALUS_FIELD_RADIUS, plan.grains, 1);
    bed.lo = plan.lo;
    bed.hi = plan.hi;
    return bed;
}

// Without its neighbours a face of the cut would give way and the sand loosen, so the outermost grains are held in place: a rough
// wall that fits. Plane walls stand a radius outside.
void hold(Bed& bed, double below, double above) {
    bed.group.assign(bed.label.size(), kFree);
    for (std::size_t i = 0; i < bed.label.size(); ++i) {
        const double x = bed.position[3 * i];
        bed.group[i] = x < below ? kFrontFace : x > above ? kBackFace : kFree;
    }
}

// Copies side by side, with a front and a back face. Sides are periodic: side walls cost next to nothing.
Bed tile(const Bed& column, const Plan& plan, double grains) {
    const double width[2] = {column.hi[0] - column.lo[0], column.hi[2] - column.lo[2]};
    const double most_x = std::max(1.0, std::floor(plan.length() / width[0])), most_z = std::max(1.0, std::floor(plan.width() / width[1]));
    const double copies = std::max(1.0, grains / static_cast<double>(column.radius.size()));
    const double nz = std::clamp(std::round(std::sqrt(copies)), 1.0, most_z), nx = std::clamp(std::round(copies / nz), 1.0, most_x);
    Bed bed;
    const auto total = static_cast<std::size_t>(nx * nz) * column.radius.size();
    bed.label.reserve(total);
    bed.position.reserve(3 * total);
    bed.radius.reserve(total);
    for (double ix = 0; ix < nx; ++ix)
        for (double iz = 0; iz < nz; ++iz)
            for (std::size_t i = 0; i < column.radius.size(); ++i) {
                bed.label.push_back(static_cast<std::int64_t>(bed.label.size()));
                bed.position.insert(bed.position.end(), {column.position[3 * i] + ix * width[0], column.position[3 * i + 1],
                                                         column.position[3 * i + 2] + iz * width[1]});
                bed.radius.push_back(column.radius[i]);
            }
    const double length = nx * width[0], thickness = std::min(kFace * plan.radius_max, 0.2 * length);
    bed.lo = {-plan.radius_max, plan.lo[1], 0};
    bed.hi = {length + plan.radius_max, plan.hi[1], nz * width[1]};
    hold(bed, thickness, length - thickness);
    return bed;
}

// The first grains behind the front wall; with a back face, if there are more.
Bed slice(const Bed& all, const Plan& plan, double grains) {
    const std::size_t count = all.radius.size();
    if (grains >= static_cast<double>(count)) return all;
    std::vector<double> x(count);
    for (std::size_t i = 0; i < count; ++i) x[i] = all.position[3 * i];
    const auto end = x.begin() + static_cast<std::ptrdiff_t>(grains);
    std::nth_element(x.begin(), end, x.end());
    const double cut = *end;
    Bed bed;
    bed.lo = plan.lo;
    bed.hi = plan.hi;
    for (std::size_t i = 0; i < count; ++i) {
        if (all.position[3 * i] > cut) continue;
        bed.label.push_back(all.label[i]);
        bed.position.insert(bed.position.end(), &all.position[3 * i], &all.position[3 * i] + 3);
        bed.radius.push_back(all.radius[i]);
    }
    bed.hi[0] = std::min(bed.hi[0], cut + plan.radius_max);
    bed.label.shrink_to_fit();
    bed.position.shrink_to_fit();
    bed.radius.shrink_to_fit();
    hold(bed, plan.lo[0], cut - kFace * plan.radius_max);
    return bed;
}

} // namespace

void set_faces(const Scene& scene, double speed) {
    const double velocity[3] = {speed, 0, 0};
    scene.engine.check(talus_group_set(scene.engine.get(), kFrontFace, TALUS_GROUP_DRIVEN, velocity, nullptr), "moving the front face");
    scene.engine.check(talus_group_set(scene.engine.get(), kBackFace, TALUS_GROUP_FROZEN, nullptr, nullptr), "holding the back face");
}

Plan Sample::settling_plan() const {
    Plan settling = plan;
    settling.has_bed_file = false;
    return settling;
}

Plan Sample::shortening_plan() const {
    Plan shortening = plan;
    shortening.has_bed_file = true;
    return shortening;
}

Sample make_sample(const Team& team, const Input& input, const std::function<void(const std::string&)>& tell) {
    Sample sample;
    sample.config = input.config;
    // The sample is a bed that is known to be sound.
    sample.config.bed.file = "the sample of calibration";
    sample.config.bed.max_overlap = 1;
    sample.config.engine.rank_grid = {0, 0, 0};
    if (!input.plan.has_bed_file) sample.config.box.periodic_z = true;
    const double wanted = std::min(kSampleGrains * team.size(), static_cast<double>(input.plan.grains));
    BedSummary summary;
    team.on_root([&] {
        if (input.plan.has_bed_file) {
            sample.bed = slice(input.bed, input.plan, wanted);
        } else {
            const Config config = column_config(input.config, input.plan);
            Faults faults;
            Plan plan = make_plan(config, std::nullopt, 0, 1, faults);
            faults.throw_if_any("the column that calibration settles");
            plan.periodic_x = true;
            tell(fmt::format("settling a column of {} grains", plan.grains));
            sample.bed = tile(settle_column(config, plan, sample.column.emplace()), input.plan, wanted);
        }
        summary = sample.bed.summary();
    });
    summary = share(team, summary);
    sample.plan = input.plan;
    sample.plan.grains = summary.count;
    sample.plan.lo = summary.lo;
    sample.plan.hi = {summary.hi[0], input.plan.hi[1], summary.hi[2]};
    return sample;
}

} // namespace talus::sandbox
