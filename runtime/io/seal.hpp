// runtime/io/seal.hpp: the commit record of a checkpoint, appended after the last byte that HDF5 knows of.
//
// It holds the digest of every bulk dataset, a hash of all other bytes of the file, and a hash of itself. A file without it was
// never finished. A changed bit anywhere fails a hash before HDF5 or the engine sees it. HDF5 ignores what follows its end.
//
//   offset from its start     what
//   0                         one SealedColumn a bulk dataset, in the order of the file
//   end - 64                  bytes before the seal, number of columns, hash of the rest of the file, hash of the seal,
//                             format version, magic
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/state_digest.hpp"
#include "runtime/io/disk_file.hpp"
#include "runtime/io/hdf5_file.hpp"

namespace talus::runtime {

inline constexpr std::uint64_t kCheckpointFormat = 2;

struct SealedColumn {
    char name[56] = {};
    Place place;
    core::Digest digest; // sum over rows of XXH3-128 of a row, seeded with its number
};
static_assert(sizeof(SealedColumn) == 96);

struct Seal {
    std::vector<SealedColumn> columns;
    const SealedColumn* find(const std::string& name) const;
};

SealedColumn seal_column(const std::string& name, const Place& place, const core::Digest& digest);

/// Add rows of up to kMaxRowBytes to a dataset's digest. @param row  number of the first one in the dataset
inline constexpr std::size_t kMaxRowBytes = 64;
void add_rows(core::Digest& digest, std::uint64_t row, const std::byte* data, std::size_t row_bytes, std::uint64_t n);

/// Append the seal to a file whose other bytes are those of `image`, and bring all to the disk.
void write_seal(const DiskFile& file, const FileImage& image, const Seal& seal);

/// Read and check a file's seal and all bytes that are not bulk data.
/// @param out_image  those bytes  @return what the bulk must be
Seal read_seal(const DiskFile& file, FileImage& out_image);

/// Whether a file ends in a seal that fits its length; its content is not looked at.
bool has_seal(const std::string& path);

} // namespace talus::runtime
