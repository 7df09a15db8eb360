// runtime/io/hdf5_file.hpp: the only face of HDF5. One rank lays out a file here (names, shapes, small values, and room for bulk
// datasets); all ranks then move the bulk themselves, by plain reads and writes at the places that HDF5 gave (columns.hpp).
//
// Why   collective HDF5 was measured and is not used. On a full disk Open MPI's collective write prints, returns success on
//       every rank, and H5Fflush hangs for ever; and two engines whose collectives sit behind the one process-wide lock that
//       the library needs could wait for each other crosswise. Here every failure is one rank's own, and can be agreed on.
// Disk  HDF5 makes no system call: it works on a FileImage in memory. What it reads has been checked before.
// Lock  every public function takes the process-wide lock for its own length and calls no other public one.
// Errors are core::Error(io) with the file, the object and HDF5's own words; HDF5 prints nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "runtime/io/file_image.hpp"

namespace talus::runtime {

/// Types of values in files, all little-endian.
enum class Kind : std::uint32_t { f64 = 0, f32 = 1, i64 = 2, i32 = 3, u64 = 4, u32 = 5, u8 = 6 };

std::size_t size_of(Kind kind);

template <class T>
constexpr Kind kind_of() {
    if constexpr (std::is_same_v<T, double>) return Kind::f64;
    else if constexpr (std::is_same_v<T, float>) return Kind::f32;
    else if constexpr (std::is_same_v<T, std::int64_t>) return Kind::i64;
    else if constexpr (std::is_same_v<T, std::int32_t>) return Kind::i32;
    else if constexpr (std::is_same_v<T, std::uint64_t>) return Kind::u64;
    else if constexpr (std::is_same_v<T, std::uint32_t>) return Kind::u32;
    else {
        static_assert(std::is_same_v<T, std::uint8_t>);
        return Kind::u8;
    }
}

/// Extents, slowest first; empty for one value.
using Shape = std::vector<std::uint64_t>;
std::uint64_t items_of(const Shape& shape);

/// Where the rows of a bulk dataset stand in the file.
struct Place {
    std::uint64_t offset = 0; // bytes from the start of the file; 0 without rows
    std::uint64_t rows = 0;
    std::uint64_t row_bytes = 0;
};

class Hdf5File {
public:
    /// A new, empty file in memory. @param name  for messages
    explicit Hdf5File(std::string name);
    /// An image that holds a whole file but for its bulk data, for reading.
    Hdf5File(std::string name, FileImage image);
    ~Hdf5File();
    Hdf5File(const Hdf5File&) = delete;
    Hdf5File& operator=(const Hdf5File&) = delete;

    // Writing. Groups on the way to an object are made.
    void add_group(const std::string& path);
    /// A soft link; the target need not exist yet.
    void add_link(const std::string& target, const std::string& path);
    void add_attribute(const std::string& object, const std::string& name, Kind kind, const Shape& shape, const void* data);
    /// Fixed-length ASCII of exactly the text's bytes.
    void add_text(const std::string& object, const std::string& name, const std::string& text);
    /// A small dataset, kept within HDF5's own bytes. @param unit  becomes an attribute, unless empty
    void add_dataset(const std::string& path, Kind kind, const Shape& shape, const void* data, const std::string& unit = {});
    /// Room for a bulk dataset, contiguous; a shape of one or two extents.
    Place reserve(const std::string& path, Kind kind, const Shape& shape, const std::string& unit = {});
    /// Close the file and take its bytes; the size of the image is that of the file with all bulk data.
    FileImage finish();

    // Reading.
    bool has(const std::string& path) const;
    /// A bulk dataset of this kind and number of columns (0: a plain list).
    Place find(const std::string& path, Kind kind, std::uint64_t columns) const;
    void read_dataset(const std::string& path, Kind kind, const Shape& shape, void* out) const;
    void read_attribute(const std::string& object, const std::string& name, Kind kind, const Shape& shape, void* out) const;
    std::string read_text(const std::string& object, const std::string& name) const;

private:
    [[noreturn]] void raise(const std::string& what) const;

    std::string name_;
    std::unique_ptr<FileImage> image_;
    std::int64_t file_ = -1;
};

} // namespace talus::runtime
