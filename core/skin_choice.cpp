#include "core/skin_choice.hpp"

#include <algorithm>
#include <cmath>

namespace talus::core {

namespace {

constexpr double kApart = 1.025; // ratio of the skins that are tried

double shell(double diameter, double skin) {
    const double reach = diameter + skin;
    return reach * reach * reach - diameter * diameter * diameter;
}

double widest(const SkinModel& m, double most) {
    const double first = kFirstSkin * m.diameter, last = std::max(first, std::min(most, kMostSkin * m.diameter));
    const double listed = kMostCandidates * m.grains;
    if (m.candidates_at(last) <= listed) return last;
    double fits = first, does_not = last;
    for (int k = 0; k < 40; ++k) {
        const double middle = 0.5 * (fits + does_not);
        (m.candidates_at(middle) <= listed ? fits : does_not) = middle;
    }
    return fits;
}

double towards(double unit, double work, double seconds) {
    const double seen = seconds / work;
    if (!(seen > 0.0) || !std::isfinite(seen)) return unit;
    return unit + 0.25 * (std::clamp(seen, 0.25 * unit, 4.0 * unit) - unit);
}

} // namespace

double SkinModel::candidates_at(double s) const { return contacts + (candidates - contacts) * shell(diameter, s) / shell(diameter, skin); }
double SkinModel::force(double s) const { return force_unit * (contacts + kCandidateWork * candidates_at(s) + kGrainWork * grains); }
double SkinModel::rebuild(double s) const { return rebuild_unit * (candidates_at(s) + kGrainRebuild * grains); }
double SkinModel::steps(double s) const { return std::max(1.0, std::min(s / near_rate, (diameter + s) / far_rate) - kLateSteps); }

void SkinModel::learn(double force_seconds, double rebuild_seconds) {
    force_unit = towards(force_unit, force(skin) / force_unit, force_seconds);
    rebuild_unit = towards(rebuild_unit, rebuild(skin) / rebuild_unit, rebuild_seconds);
}

double fastest_skin(const SkinModel& m, double most) {
    const double least = kLeastSkin * m.diameter, last = widest(m, most);
    double best = last, best_time = m.time(last);
    for (double s = least; s < last; s *= kApart) {
        const double time = m.time(s);
        if (time < best_time) {
            best = s;
            best_time = time;
        }
    }
    return best;
}

double next_skin(const SkinModel& m, double most) {
    const double now = std::clamp(m.skin, kLeastSkin * m.diameter, widest(m, most)), best = fastest_skin(m, most);
    // Judged by where it leads: a first step may gain nothing, when lists are rebuilt in every step before and after it.
    return m.time(best) < (1.0 - kSkinGain) * m.time(now) ? std::clamp(best, now / kSkinFactor, now * kSkinFactor) : now;
}

bool outlived(const SkinModel& m, double most, double steps) {
    const double next = next_skin(m, most);
    return steps * (m.time(m.skin) - m.time(next)) > m.rebuild(next);
}

} // namespace talus::core
