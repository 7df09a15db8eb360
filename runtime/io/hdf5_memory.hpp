// runtime/io/hdf5_memory.hpp: an HDF5 file driver over a FileImage, so that HDF5 makes no system call of its own.
#pragma once

#include <hdf5.h>

#include "runtime/io/file_image.hpp"

namespace talus::runtime {

/// Make a file-access list use `image`, which must outlive the file opened with it. Call under the lock of HDF5.
/// @return false when HDF5 refuses
bool use_image(hid_t access_list, FileImage& image);

} // namespace talus::runtime
