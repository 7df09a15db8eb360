#include "runtime/io/vtkhdf.hpp"

#include <cstring>

namespace talus::runtime {

namespace {

constexpr std::uint8_t kVertex = 1; // VTK's number of a cell that is one point

/// 0, 1, 2 ...: row k of a rank is k.
void count_up(std::uint64_t row, std::uint64_t n, std::byte* bytes) {
    for (std::uint64_t k = 0; k < n; ++k) {
        const auto value = static_cast<std::int64_t>(row + k);
        std::memcpy(bytes + k * sizeof value, &value, sizeof value);
    }
}

} // namespace

void add_vtk_header(Hdf5File& file, const std::vector<std::int64_t>& grains, double time) {
    file.add_group("/VTKHDF/PointData");
    file.add_group("/VTKHDF/CellData");
    const std::int64_t version[2] = {1, 0};
    file.add_attribute("/VTKHDF", "Version", Kind::i64, {2}, version);
    file.add_text("/VTKHDF", "Type", "UnstructuredGrid");
    for (const char* name : {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"})
        file.add_dataset(std::string("/VTKHDF/") + name, Kind::i64, {grains.size()}, grains.data());
    file.add_dataset("/VTKHDF/FieldData/TimeValue", Kind::f64, {1}, &time, "s");
}

void add_vtk_points(Hdf5File& file, const std::string& target) { file.add_link(target, "/VTKHDF/Points"); }

void add_vtk_point_array(Hdf5File& file, const std::string& name, const std::string& target) { file.add_link(target, "/VTKHDF/PointData/" + name); }

std::vector<Column> vtk_columns(const Communicator& comm, const Rows& grains) {
    const auto ranks = static_cast<std::uint64_t>(comm.size()), rank = static_cast<std::uint64_t>(comm.rank());
    const auto vertices = [](std::uint64_t, std::uint64_t n, std::byte* bytes) { std::memset(bytes, kVertex, n); };
    // Offsets begin at zero in each part, and have one more than cells.
    const Rows offsets{grains.first + rank, grains.count + 1, grains.total + ranks};
    return {{"/VTKHDF/Connectivity", "", Kind::i64, 0, grains, count_up},
            {"/VTKHDF/Types", "", Kind::u8, 0, grains, vertices},
            {"/VTKHDF/Offsets", "", Kind::i64, 0, offsets, count_up}};
}

} // namespace talus::runtime
