#include "runtime/io/disk_file.hpp"

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/error.hpp"

namespace talus::runtime {

using core::ErrorKind;
using core::fail;

namespace {

std::string words_of_system(int error) { return std::generic_category().message(error); }

std::string folder_of(const std::string& path) {
    const std::size_t slash = path.rfind('/');
    return slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

void sync_folder(const std::string& path) {
    const std::string folder = folder_of(path);
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) fail(ErrorKind::io, "{}: its folder cannot be opened: {}", path, words_of_system(errno));
    const int error = ::fsync(descriptor) == 0 ? 0 : errno;
    ::close(descriptor);
    // EINVAL: a file system without it.
    if (error != 0 && error != EINVAL) fail(ErrorKind::io, "{}: its folder cannot be brought to the disk: {}", path, words_of_system(error));
}

void rename_file(const std::string& from, const std::string& to) {
    if (std::rename(from.c_str(), to.c_str()) != 0) fail(ErrorKind::io, "{}: cannot be renamed to {}: {}", from, to, words_of_system(errno));
}

} // namespace

DiskFile::DiskFile(const std::string& path, int flags, const char* purpose) : path_(path) {
    do descriptor_ = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
    while (descriptor_ < 0 && errno == EINTR);
    if (descriptor_ < 0) raise(purpose, errno);
    struct stat status;
    if (::fstat(descriptor_, &status) == 0 && !S_ISREG(status.st_mode)) {
        ::close(std::exchange(descriptor_, -1));
        fail(ErrorKind::io, "{}: is not a regular file", path_);
    }
}

DiskFile DiskFile::create(const std::string& path) { return {path, O_RDWR | O_CREAT | O_TRUNC, "cannot be created"}; }
DiskFile DiskFile::open_to_write(const std::string& path) { return {path, O_RDWR, "cannot be opened for writing"}; }
DiskFile DiskFile::open_to_read(const std::string& path) { return {path, O_RDONLY | O_NONBLOCK, "cannot be opened"}; }

DiskFile::DiskFile(DiskFile&& other) noexcept : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

DiskFile& DiskFile::operator=(DiskFile&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(descriptor_, other.descriptor_);
    return *this;
}

DiskFile::~DiskFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

void DiskFile::raise(const char* what, int error) const { fail(ErrorKind::io, "{}: {}: {}", path_, what, words_of_system(error)); }

std::uint64_t DiskFile::size() const {
    struct stat status;
    if (::fstat(descriptor_, &status) != 0) raise("its size cannot be had", errno);
    return static_cast<std::uint64_t>(status.st_size);
}

void DiskFile::read(std::uint64_t at, void* out, std::size_t n) const {
    for (std::size_t done = 0; done < n;) {
        const ssize_t got = ::pread(descriptor_, static_cast<char*>(out) + done, n - done, static_cast<off_t>(at + done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) raise("cannot be read", errno);
        if (got == 0) fail(ErrorKind::io, "{}: ends at byte {}, within the {} bytes from {}: it was cut short", path_, at + done, n, at);
        done += static_cast<std::size_t>(got);
    }
}

void DiskFile::write(std::uint64_t at, const void* data, std::size_t n) const {
    for (std::size_t done = 0; done < n;) {
        const ssize_t put = ::pwrite(descriptor_, static_cast<const char*>(data) + done, n - done, static_cast<off_t>(at + done));
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) raise("cannot be written", put < 0 ? errno : ENOSPC);
        done += static_cast<std::size_t>(put);
    }
}

void DiskFile::resize(std::uint64_t n) const {
    if (::ftruncate(descriptor_, static_cast<off_t>(n)) != 0) raise("cannot be given its size", errno);
}

void DiskFile::reserve(std::uint64_t n) const {
    int result;
    do result = n > 0 ? ::fallocate(descriptor_, 0, 0, static_cast<off_t>(n)) : 0;
    while (result != 0 && errno == EINTR);
    if (result != 0 && errno != EOPNOTSUPP && errno != ENOSYS) raise("there is no room for it", errno);
}

void DiskFile::sync() const {
    int result;
    do result = ::fsync(descriptor_);
    while (result != 0 && errno == EINTR);
    if (result != 0) raise("cannot be brought to the disk", errno);
}

void DiskFile::close() {
    if (::close(std::exchange(descriptor_, -1)) != 0 && errno != EINTR) raise("cannot be closed", errno);
}

bool file_exists(const std::string& path) {
    struct stat status;
    return ::stat(path.c_str(), &status) == 0;
}

void remove_file(const std::string& path) noexcept { ::unlink(path.c_str()); }

std::string partial_name(const std::string& path) { return path + ".partial"; }
std::string previous_name(const std::string& path) { return path + ".previous"; }

void put_in_place(const std::string& path, bool keep_previous) {
    if (keep_previous && file_exists(path)) {
        // A second name first, so that `path` is never missing; file systems without hard links must do with a rename.
        const std::string second = partial_name(previous_name(path));
        remove_file(second);
        rename_file(::link(path.c_str(), second.c_str()) == 0 ? second : path, previous_name(path));
    }
    rename_file(partial_name(path), path);
    sync_folder(path);
}

} // namespace talus::runtime
