// runtime/io/vtkhdf.hpp: what makes an HDF5 file one that ParaView opens: /VTKHDF of type UnstructuredGrid, version 1.0, every
// grain a vertex, one part a rank. The file's name must end in .hdf for ParaView to try.
#pragma once

#include "runtime/io/columns.hpp"

namespace talus::runtime {

/// Attributes, sizes of parts and time. @param grains  of each rank
void add_vtk_header(Hdf5File& file, const std::vector<std::int64_t>& grains, double time);
/// Let the dataset N x 3 at `target` be the points.
void add_vtk_points(Hdf5File& file, const std::string& target);
/// Let the dataset at `target` show in ParaView as a point array.
void add_vtk_point_array(Hdf5File& file, const std::string& name, const std::string& target);
/// The columns that describe the vertices.
std::vector<Column> vtk_columns(const Communicator& comm, const Rows& grains);

} // namespace talus::runtime
