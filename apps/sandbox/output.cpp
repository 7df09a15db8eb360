#include "output.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <regex>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace talus::sandbox {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void io_failure(const std::string& path, const std::string& why) {
    throw Failure(kExitIo, path + ": cannot be written: " + why);
}

} // namespace

void OutputFolder::create() {
    team_.on_root([&] {
        std::error_code error;
        fs::create_directories(path_, error);
        if (error) io_failure(path_, error.message());
        static const std::regex ours(R"(run_[0-9]{4,}\.hdf|run\.hdf\.series|run\.ckpt|walls\.csv|energy\.csv|summary\.json)");
        for (const fs::directory_entry& entry : fs::directory_iterator(path_, error))
            if (std::regex_match(entry.path().filename().string(), ours)) fs::remove(entry.path(), error);
        // Writing is tried now: after an hour of settling it would be late.
        const std::string probe = file(".talus-probe");
        if (std::FILE* stream = std::fopen(probe.c_str(), "w"))
            std::fclose(stream);
        else
            io_failure(path_, std::strerror(errno));
        fs::remove(probe, error);
    });
}

void OutputFolder::write_text(const std::string& name, const std::string& text) const {
    team_.on_root([&] {
        const std::string path = file(name);
        const std::string part = path + ".part";
        std::FILE* stream = std::fopen(part.c_str(), "w");
        if (stream == nullptr) io_failure(path, std::strerror(errno));
        const bool is_written = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
        std::error_code error;
        if (std::fclose(stream) != 0 || !is_written)
            error.assign(errno, std::generic_category());
        else
            fs::rename(part, path, error);
        if (!error) return;
        std::error_code ignored;
        fs::remove(part, ignored);
        io_failure(path, error.message());
    });
}

TimeSeries::TimeSeries(const Team& team, const OutputFolder& folder, const std::string& name, const std::vector<std::string>& columns)
    : team_(team), path_(folder.file(name)) {
    folder.write_text(name, fmt::format("{}\n", fmt::join(columns, ",")));
    team_.on_root([&] {
        file_ = std::fopen(path_.c_str(), "a");
        if (file_ == nullptr) io_failure(path_, std::strerror(errno));
        // No buffer: it would write the rest of a line that failed when the file is closed.
        std::setvbuf(file_, nullptr, _IONBF, 0);
        std::fseek(file_, 0, SEEK_END);
    });
}

TimeSeries::~TimeSeries() {
    if (file_ != nullptr) std::fclose(file_);
}

void TimeSeries::add(std::int64_t step, const std::vector<double>& values) {
    team_.on_root([&] {
        const std::string line = fmt::format("{},{}\n", step, fmt::join(values, ","));
        // Written line by line, and half a line is taken back: what is in the file after a kill or on a full disk is whole.
        const long before = std::ftell(file_);
        if (std::fwrite(line.data(), 1, line.size(), file_) == line.size()) return;
        const int error = errno;
        if (before < 0 || ftruncate(fileno(file_), before) != 0) std::clearerr(file_);
        io_failure(path_, std::strerror(error));
    });
}

namespace {

std::vector<std::string> wall_columns(const Scene& scene) {
    std::vector<std::string> columns{"step", "time"};
    for (const Wall& wall : scene.walls)
        for (const char* what : {"fx", "fy", "fz", "px", "py", "pz"}) columns.push_back(wall.name + "_" + what);
    return columns;
}

} // namespace

WallSeries::WallSeries(const Team& team, const OutputFolder& folder, const Scene& scene)
    : series_(team, folder, "walls.csv", wall_columns(scene)) {}

void WallSeries::add(const Scene& scene, std::int64_t step, double time) {
    std::vector<double> values{time};
    for (const Wall& wall : scene.walls) {
        talus_wall_state state = {};
        state.struct_size = sizeof state;
        scene.engine.check(talus_wall_get(scene.engine.get(), wall.id, &state), "reading the wall " + wall.name);
        values.insert(values.end(), state.force, state.force + 3);
        values.insert(values.end(), state.point, state.point + 3);
    }
    series_.add(step, values);
}

EnergySeries::EnergySeries(const Team& team, const OutputFolder& folder)
    : series_(team, folder, "energy.csv",
              {"step", "time", "kinetic", "rotational", "elastic_normal", "elastic_tangential", "elastic_rolling", "gravity", "wall_work",
               "friction", "damping", "rolling"}) {}

void EnergySeries::add(const Scene& scene, std::int64_t step, double time) {
    talus_energy e;
    talus_energy_init(&e);
    scene.engine.check(talus_engine_energy(scene.engine.get(), &e), "reading the energies");
    series_.add(step, {time, e.kinetic, e.rotational, e.elastic_normal, e.elastic_tangential, e.elastic_rolling, e.gravity, e.wall_work,
                       e.friction, e.damping, e.rolling});
}

void Snapshots::write(const Scene& scene, std::int64_t step, double time, double shortening) {
    const std::string name = fmt::format("run_{:04}.hdf", records_.size());
    const std::string path = folder_.file(name);
    scene.engine.check(talus_snapshot_write(scene.engine.get(), path.c_str()), "writing a snapshot");
    records_.push_back({name, step, time, shortening});
    nlohmann::ordered_json series;
    series["file-series-version"] = "1.0";
    for (const SnapshotRecord& record : records_) series["files"].push_back({{"name", record.file}, {"time", record.time}});
    folder_.write_text("run.hdf.series", series.dump(1) + "\n");
}

} // namespace talus::sandbox
