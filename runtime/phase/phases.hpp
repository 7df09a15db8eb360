// runtime/phase/phases.hpp: the phases of a run, each in its own file; every one works on an EngineState.
//
//   phase          reads                                  writes                                 talks
//   binning        owned grains, slices                   order of owned grains, tiles           -
//   halo_exchange  grains near cuts                       ghosts                                 neighbours
//   pair_build     grains, ghosts, contact store          candidate lists, histories, borders    -
//   force          grains, ghosts, lists                  sums, histories of one tile            -
//   integrate      sums, neighbours' border rows          grains, sums of one tile               -
//   skin           counts, times and use of the lists     the skin of the next ones              all
//   rebalance      grains, seconds of tiles               cuts; which rank owns which grain      all
//   observe        everything                             nothing                                all
//
// A rebuild is: give up the tiles, choose the skin, rebalance (cuts, migrate), binning, halo build, pair build with inheritance.
#pragma once

#include "runtime/engine_state.hpp"

namespace talus::runtime {

/// Index the touching contacts of the tiles grain by grain (the paper's Fig. 1); slots are the owned grains. The store speaks of the
/// tiles until they change. [local]
void lay_out_contacts(EngineState& s, core::ContactStore& store);
/// Give up the tiles and ghosts: contacts go to sub.contacts, which speaks of sub.old_tiles, heat to sub.heat, and sums to sub.sums
/// if anybody will ask for them before the next force evaluation. Nothing to do if that has been done since the last build. [local]
void empty_tiles(EngineState& s, bool keep_sums);
/// Notes on the lists, from which the next skin follows: when they are built, before they go, and at every verdict on them.
/// @param rebuild_seconds  that they took, times threads [local]
void begin_watch(EngineState& s, double rebuild_seconds);
void end_watch(EngineState& s);
/// The arguments must be the same on all ranks. @return whether it is time for a better skin [local]
bool watch_lists(EngineState& s, std::int64_t steps, double skin_use, double apart);
/// Choose the skin of the coming lists, if it is automatic. [collective]
void choose_skin(EngineState& s);
/// Equal subdomains, as many along each axis as the settings say, or as give the grains there are the least halos. [collective]
void choose_slices(EngineState& s);
/// Move cuts if the policy says so, and migrate. @param first  there are no cuts that follow the grains yet [collective]
void rebalance(EngineState& s, bool first);
/// Notes on the work of this rank from here on. @param rebuild_seconds  that the rebuild took [local]
void begin_load(EngineState& s, double rebuild_seconds);
/// What a rank has to say on whether lists that have served so many steps hold up a better balance; 0 most of the time. [local]
struct LoadOpinion {
    double busy = 0.0, rebuild = 0.0; // s since the lists were built; s a rebuild takes
};
LoadOpinion load_opinion(const EngineState& s, std::int64_t steps);
/// Whether lists are to be rebuilt so that cuts can move. The arguments are the extremes over ranks. [local]
bool outlived_balance(const EngineState& s, std::int64_t steps, double busiest, double idlest, double rebuild_seconds);
/// Bring every grain to its owner with all that stands beside it. [collective]
void migrate(EngineState& s);
/// Order the owned grains by tile, cell and label; give tiles their ranges. Fails on grains outside the domain. [local]
void bin_grains(EngineState& s);
/// Candidate lists, borders and inherited histories of all tiles (the paper's Fig. 8). [local]
void build_pairs(EngineState& s);
/// The whole of a rebuild. @param keep_sums  see empty_tiles [collective]
void rebuild(EngineState& s, bool first, bool keep_sums);

/// Nodes of the step graph; they never throw.
void force_tile(EngineState& s, int tile);
void integrate_tile(EngineState& s, int tile);

/// Largest share of the skin that any listed pair may have used up: now, and as foreseen. >= 1 means the lists may miss a pair.
struct SkinUse {
    double now = 0.0, foreseen = 0.0;
    core::DisplacementBox all; // of every grain of this rank: pairs that start too far apart for the above are judged over all ranks
};
SkinUse skin_use(const EngineState& s);

/// Fill the contexts that the nodes read from the model. [local]
void refresh_contexts(EngineState& s);

} // namespace talus::runtime
