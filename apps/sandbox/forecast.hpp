// forecast.hpp: what an experiment will take on so many ranks and threads: steps, memory, files, messages and time. A pure function of
// the plan, of measured costs and of a stated network; nothing in it grows with the number of grains or ranks.
#ifndef TALUS_SANDBOX_FORECAST_HPP
#define TALUS_SANDBOX_FORECAST_HPP

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "config.hpp"
#include "costs.hpp"
#include "plan.hpp"

namespace talus::sandbox {

struct Machine {
    std::int32_t ranks = 1;
    std::int32_t threads = 1;          // of each rank
    double latency = 2e-6;             // [s] a message
    double bandwidth = 10e9;           // [byte/s] of a rank
    double write_bytes_per_second = 0; // to files, all ranks together; 0: as measured
};

// What the rank with most neighbours holds and sends. Sand fills length x depth x width with a uniform number density n, and a
// subdomain is the share a1 x a2 x a3 of it. Of an axis that is cut, s = 1 (two subdomains) or 2 sides have a neighbour. With the
// reach h = largest diameter + skin,
//   ghosts   = n ((a1 + s1 h)(a2 + s2 h)(a3 + s3 h) - a1 a2 a3)      which are received, and as many sent
//   chunks   = (m1 + s1)(m2 + s2)(m3 + s3) - m1 m2 m3                  tiles of the sender near the border; m: tiles along an axis
//   messages = (1 + s1)(1 + s2)(1 + s3) - 1                            at most, one to each neighbour
//   bytes    = 96 (ghosts + chunks)                                      sent, and as many received
struct Halo {
    std::array<std::int32_t, 3> grid{1, 1, 1};
    std::array<double, 3> size{}; // [m] of a subdomain, as far as it is filled with sand
    double ghosts = 0;
    double messages = 0;
    double bytes = 0;
};

struct StageForecast {
    std::int64_t steps = 0;
    double seconds = 0;
    double network_seconds = 0; // of these
};

struct FilesForecast {
    double settled_bed = 0; // [byte]; 0 if it is not kept
    double checkpoint = 0;  // run.ckpt, 0 if none is written
    std::int64_t checkpoints = 0;
    double snapshot = 0;
    std::int64_t snapshots = 0;
    double walls = 0;   // walls.csv
    double on_disk = 0; // all that is there at the end
    double written = 0;
};

struct Forecast {
    Machine machine;
    Halo halo;
    double rank_grains = 0;           // of the fullest rank
    double rank_bytes = 0, bytes = 0; // peak of resident memory: of the fullest rank, and of all
    FilesForecast files;
    bool settling_is_measured = false;
    StageForecast settle, shorten;
    double start_seconds = 0; // fill or insertion and first lists
    double file_seconds = 0;
    double seconds = 0;                   // in all
    std::vector<std::string> assumptions; // a sentence each
};

Halo halo_of(const Config& config, const Plan& plan, std::int32_t ranks, double skin_diameters);

// Throws a Failure if the ranks cannot share the box.
Forecast make_forecast(const Config& config, const Plan& plan, const Costs& costs, const Machine& machine);

// Lines for people, and JSON.
std::string forecast_text(const Config& config, const Plan& plan, const Costs& costs, const Forecast& forecast);
std::string forecast_json(const Config& config, const Plan& plan, const Costs& costs, const Forecast& forecast);

// Peak of resident memory of the fullest rank, by built-in costs, for runs, which measure nothing first; and a line that tells it.
double expected_rank_bytes(const Config& config, const Plan& plan, std::int32_t ranks);
std::string memory_text(const Config& config, const Plan& plan, std::int32_t ranks);

} // namespace talus::sandbox

#endif
