// output.hpp: the output folder. Rank 0 writes texts and the engine writes snapshots and checkpoints; every file gets
// its name only when it is whole, except the time series, which grow by whole lines. All functions are collective; a
// full disk ends the run on every rank.
#ifndef TALUS_SANDBOX_OUTPUT_HPP
#define TALUS_SANDBOX_OUTPUT_HPP

#include <cstdio>
#include <string>
#include <vector>

#include "scene.hpp"
#include "team.hpp"

namespace talus::sandbox {

class OutputFolder {
public:
    OutputFolder(const Team& team, std::string path) : team_(team), path_(std::move(path)) {}

    // Makes the folder and takes away what an earlier run left in it. Kept beds stay.
    void create();
    std::string file(const std::string& name) const { return path_ + "/" + name; }
    void write_text(const std::string& name, const std::string& text) const;

private:
    const Team& team_;
    std::string path_;
};

// A CSV file that grows. Numbers are written with as many digits as it takes to read the same bits back.
class TimeSeries {
public:
    TimeSeries(const Team& team, const OutputFolder& folder, const std::string& name, const std::vector<std::string>& columns);
    ~TimeSeries();
    TimeSeries(const TimeSeries&) = delete;
    TimeSeries& operator=(const TimeSeries&) = delete;

    void add(std::int64_t step, const std::vector<double>& values);

private:
    const Team& team_;
    std::string path_;
    std::FILE* file_ = nullptr;
};

// walls.csv: force on each wall and a point of it. energy.csv, with [engine] energy_ledger: the terms of the ledger.
class WallSeries {
public:
    WallSeries(const Team& team, const OutputFolder& folder, const Scene& scene);
    void add(const Scene& scene, std::int64_t step, double time);

private:
    TimeSeries series_;
};
class EnergySeries {
public:
    EnergySeries(const Team& team, const OutputFolder& folder);
    void add(const Scene& scene, std::int64_t step, double time);

private:
    TimeSeries series_;
};

struct SnapshotRecord {
    std::string file;
    std::int64_t step = 0; // of the engine's clock, settling included
    double time = 0;       // [s]
    double shortening = 0; // [m]
};

// run_0000.hdf, run_0001.hdf, ... and run.hdf.series, which ParaView opens as one.
class Snapshots {
public:
    explicit Snapshots(const OutputFolder& folder) : folder_(folder) {}
    void write(const Scene& scene, std::int64_t step, double time, double shortening);
    const std::vector<SnapshotRecord>& records() const { return records_; }

private:
    const OutputFolder& folder_;
    std::vector<SnapshotRecord> records_;
};

} // namespace talus::sandbox

#endif
