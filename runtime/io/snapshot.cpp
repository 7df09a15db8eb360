#include "runtime/io/snapshot.hpp"

#include <cstring>

#include "runtime/io/vtkhdf.hpp"

namespace talus::runtime {

namespace {

/// A column of one to three values a grain; `value(grain, component)`.
template <class T, class Value>
Column column_of(const char* name, const char* unit, std::uint64_t width, const Rows& rows, Value value) {
    const std::uint64_t components = width == 0 ? 1 : width;
    const auto fill = [=](std::uint64_t row, std::uint64_t n, std::byte* bytes) {
        for (std::uint64_t k = 0; k < n; ++k)
            for (std::uint64_t c = 0; c < components; ++c) {
                const T v = static_cast<T>(value(row + k, c));
                std::memcpy(bytes + (k * components + c) * sizeof v, &v, sizeof v);
            }
    };
    return {std::string("/VTKHDF/") + name, unit, kind_of<T>(), width, rows, fill};
}

} // namespace

void write_snapshot(EngineState& s, const std::string& path) {
    const std::vector<std::int64_t> counts = count_by_rank(*s.comm, s.sub.n_owned);
    const Rows rows = rows_in_rank_order(counts, s.comm->rank());
    const core::Particle* p = s.sub.particles.data();
    const core::Reference* origin = s.sub.references.data();
    const int rank = s.comm->rank();
    const Model& m = s.model;

    NewFile file;
    file.path = path;
    file.columns = vtk_columns(*s.comm, rows);
    file.columns.push_back(column_of<double>("Points", "m", 3, rows, [=](std::uint64_t i, std::uint64_t c) { return p[i].position[c]; }));
    file.columns.push_back(column_of<std::int64_t>("PointData/label", "", 0, rows, [=](std::uint64_t i, std::uint64_t) { return p[i].label; }));
    file.columns.push_back(column_of<float>("PointData/radius", "m", 0, rows, [=](std::uint64_t i, std::uint64_t) { return p[i].radius; }));
    file.columns.push_back(column_of<float>("PointData/velocity", "m/s", 3, rows, [=](std::uint64_t i, std::uint64_t c) { return p[i].velocity[c]; }));
    // The origin follows a grain through periodic wraps, so the plain difference is its way.
    file.columns.push_back(column_of<float>("PointData/displacement", "m", 3, rows, [=](std::uint64_t i, std::uint64_t c) { return p[i].position[c] - origin[i][c]; }));
    file.columns.push_back(column_of<std::int32_t>("PointData/colour", "", 0, rows, [=](std::uint64_t i, std::uint64_t) { return core::colour_of(p[i]); }));
    file.columns.push_back(column_of<std::int32_t>("PointData/owner", "", 0, rows, [=](std::uint64_t, std::uint64_t) { return rank; }));
    file.lay_out = [&](Hdf5File& hdf5) {
        const core::Domain& d = m.settings.domain;
        const std::int64_t periodic[3] = {d.periodic[0], d.periodic[1], d.periodic[2]};
        hdf5.add_attribute("/", "box_lo", Kind::f64, {3}, d.lo);
        hdf5.add_attribute("/", "box_hi", Kind::f64, {3}, d.hi);
        hdf5.add_attribute("/", "periodic", Kind::i64, {3}, periodic);
        hdf5.add_attribute("/", "time", Kind::f64, {}, &m.time);
        hdf5.add_attribute("/", "step", Kind::i64, {}, &m.step);
        add_vtk_header(hdf5, counts, m.time);
    };
    write_file(s, file);
}

} // namespace talus::runtime
