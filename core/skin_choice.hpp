// core/skin_choice.hpp: the list skin for which a step takes least time. A pure function of what is known of the lists, of nothing but
// + - * / and comparisons, so that ranks on different processors choose the same to the bit.
//
// A wide skin lists candidates that the force filters in vain; a narrow one is used up soon, and lists must be rebuilt. The time
// that depends on the skin s is, a step,
//   T(s) = force(s) + rebuild(s) / steps(s)
//   force(s)      = force_unit (contacts + kCandidateWork candidates(s) + kGrainWork grains)
//   rebuild(s)    = rebuild_unit (candidates(s) + kGrainRebuild grains)
//   candidates(s) = contacts + what is listed without contact, in proportion to the volume (d + s)^3 - d^3 around a grain
//   steps(s)      = min(s / near_rate, (d + s) / far_rate) - kLateSteps, and not below one
// since lists are rebuilt when neighbours came nearer by a skin, or any two grains by a diameter and a skin. The two units are
// measured; of the works only ratios are needed, calibrated on a settled bed. T is flat about its least value: skins that
// differ by a fifth differ in time by a few per cent of what rebuilds cost, so calibration and noise matter little.
#pragma once

namespace talus::core {

inline constexpr double kFirstSkin = 0.1;                        // of the largest diameter, before anything is known
inline constexpr double kLeastSkin = 0.02, kMostSkin = 0.5;      // of the largest diameter: range of the choice
inline constexpr double kMostCandidates = 6.0;                   // a grain, for memory's sake; the first skin may list more
inline constexpr double kCandidateWork = 0.12, kGrainWork = 0.3;  // of the force on a contact
inline constexpr double kGrainRebuild = 8.0;                     // of what a candidate takes at a rebuild
inline constexpr double kLateSteps = 2.0;                        // of the three steps foreseen, the decision takes one to arrive
inline constexpr double kSkinFactor = 1.5;                       // most change at once
inline constexpr double kSkinGain = 0.01;                        // share of T for which the skin is changed

/// What is known of a list that has been in use, over all ranks, and of the costs of all lists so far.
struct SkinModel {
    double diameter = 0.0; // m, of the largest grain
    double skin = 0.0;     // m, of the list
    double grains = 0.0, contacts = 0.0, candidates = 0.0; // contacts are candidates too; without any nothing is known yet
    double near_rate = 0.0; // m a step: largest relative displacement of grains of neighbouring tiles
    double far_rate = 0.0;  // m a step: largest relative displacement of any two grains
    double force_unit = 30e-9, rebuild_unit = 45e-9; // s

    double candidates_at(double s) const;
    double force(double s) const;   // s
    double rebuild(double s) const; // s
    double steps(double s) const;
    double time(double s) const { return force(s) + rebuild(s) / steps(s); } // s a step

    /// Learn the units from the seconds that a force evaluation and the rebuild of this list took, a quarter of the way: one list's
    /// life may be short and noisy. What is not positive and finite teaches nothing.
    void learn(double force_seconds, double rebuild_seconds);
};

/// The skin of least time in the range of the choice, up to `most` (but for kFirstSkin, which a run always has room for) [m].
double fastest_skin(const SkinModel& m, double most);
/// The skin of the next list: towards the fastest one by at most a factor kSkinFactor; that of this list, brought into the range, if
/// the fastest one gains too little [m].
double next_skin(const SkinModel& m, double most);
/// Whether a list that has served `steps` steps, and may serve many more, is to be replaced by one with the next skin: when what it
/// has cost too much so far is what a rebuild costs. So grains at rest, which need no rebuild, get a narrow skin too.
bool outlived(const SkinModel& m, double most, double steps);

} // namespace talus::core
