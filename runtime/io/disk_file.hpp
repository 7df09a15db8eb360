// runtime/io/disk_file.hpp: files by plain system calls, every return checked; and how a new file takes the place of an old one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace talus::runtime {

/// An open file. Failures are core::Error(io) with the file's name, what was tried, and the system's words.
class DiskFile {
public:
    /// Empty, for reading and writing.
    static DiskFile create(const std::string& path);
    static DiskFile open_to_write(const std::string& path);
    static DiskFile open_to_read(const std::string& path);
    DiskFile(DiskFile&& other) noexcept;
    DiskFile& operator=(DiskFile&& other) noexcept;
    ~DiskFile();

    const std::string& path() const { return path_; }
    std::uint64_t size() const;
    /// Reads and writes may come from several threads at once.
    void read(std::uint64_t at, void* out, std::size_t n) const;
    void write(std::uint64_t at, const void* data, std::size_t n) const;
    void resize(std::uint64_t n) const;
    /// Take the room on the disk now, where the file system can: a disk too small shows before anything is written.
    void reserve(std::uint64_t n) const;
    /// Bring everything to the disk.
    void sync() const;
    /// Some file systems report failed writes only here.
    void close();

private:
    DiskFile(const std::string& path, int flags, const char* purpose);
    [[noreturn]] void raise(const char* what, int error) const;

    std::string path_;
    int descriptor_ = -1;
};

bool file_exists(const std::string& path);
void remove_file(const std::string& path) noexcept;

/// The name under which a file is written until it is whole; one a target, so that what a kill leaves behind is overwritten.
std::string partial_name(const std::string& path);
/// The name under which the file before this one is kept.
std::string previous_name(const std::string& path);

/// Give the finished `partial_name(path)` its name, and bring the folder to the disk. At every moment one whole file stands
/// under `path` or `previous_name(path)`.
/// @param keep_previous  the file that stood there becomes previous_name(path)
void put_in_place(const std::string& path, bool keep_previous);

} // namespace talus::runtime
