#include "runtime/io/seal.hpp"

#include <algorithm>
#include <cstring>

#include "core/error.hpp"

namespace talus::runtime {

using core::ErrorKind;
using core::fail;

namespace {

constexpr char kMagic[8] = {'T', 'A', 'L', 'U', 'S', 'E', 'N', 'D'};

struct Hash {
    std::uint64_t lo = 0, hi = 0;
    bool operator==(const Hash&) const = default;
};

struct SealEnd {
    std::uint64_t body_bytes;
    std::uint64_t n_columns;
    Hash rest;
    Hash self; // of the columns and of this record before it
    std::uint64_t format;
    char magic[8];
};
static_assert(sizeof(SealEnd) == 64);

/// More datasets than any version of the format has.
constexpr std::uint64_t kMaxColumns = 1024;

void add_hash(core::Digest& digest, const XXH128_hash_t& h) {
    digest.lo += h.low64;
    digest.hi += h.high64;
}

/// A length that the compiler knows leaves a few instructions of the hash.
template <std::size_t kBytes>
[[gnu::flatten]] void add_rows_of(core::Digest& digest, std::uint64_t row, const std::byte* data, std::uint64_t n) {
    core::Digest sum;
    for (std::uint64_t k = 0; k < n; ++k) add_hash(sum, XXH3_128bits_withSeed(data + k * kBytes, kBytes, row + k));
    digest.lo += sum.lo;
    digest.hi += sum.hi;
}

Hash hash_of(const XXH128_hash_t& h) { return {h.low64, h.high64}; }

Hash hash_of_seal(const std::vector<SealedColumn>& columns, const SealEnd& end) {
    std::vector<std::byte> bytes(columns.size() * sizeof(SealedColumn) + offsetof(SealEnd, self) + sizeof end.format);
    std::byte* at = bytes.data();
    const auto put = [&](const void* data, std::size_t n) {
        if (n > 0) std::memcpy(at, data, n);
        at += n;
    };
    put(columns.data(), columns.size() * sizeof(SealedColumn));
    put(&end, offsetof(SealEnd, self));
    put(&end.format, sizeof end.format);
    return hash_of(XXH3_128bits(bytes.data(), bytes.size()));
}

/// visit(offset, bytes) of each stretch that no column covers, in order.
/// @return false when columns overlap or go beyond the end
template <class Visit>
bool each_rest(std::vector<SealedColumn> columns, std::uint64_t end, Visit visit) {
    std::erase_if(columns, [](const SealedColumn& c) { return c.place.rows == 0; });
    std::sort(columns.begin(), columns.end(), [](const SealedColumn& a, const SealedColumn& b) { return a.place.offset < b.place.offset; });
    std::uint64_t at = 0;
    for (const SealedColumn& c : columns) {
        const Place& p = c.place;
        if (p.offset < at || p.offset > end || p.row_bytes == 0 || p.rows > (end - p.offset) / p.row_bytes) return false;
        visit(at, p.offset - at);
        at = p.offset + p.rows * p.row_bytes;
    }
    visit(at, end - at);
    return true;
}

/// Hash of the image's bytes outside of the columns.
Hash hash_of_rest(const std::vector<SealedColumn>& columns, const FileImage& image) {
    XXH3_state_t* state = XXH3_createState();
    if (state == nullptr) throw std::bad_alloc();
    XXH3_128bits_reset(state);
    std::byte buffer[4096];
    const bool sound = each_rest(columns, image.size(), [&](std::uint64_t at, std::uint64_t n) {
        for (std::uint64_t done = 0; done < n;) {
            const std::size_t count = std::min<std::uint64_t>(sizeof buffer, n - done);
            image.read(at + done, buffer, count);
            XXH3_128bits_update(state, buffer, count);
            done += count;
        }
    });
    const Hash h = hash_of(XXH3_128bits_digest(state));
    XXH3_freeState(state);
    TALUS_CHECK(sound);
    return h;
}

/// Bytes of a file that HDF5 alone wrote; more than any number of walls and materials needs.
constexpr std::uint64_t kMaxRest = std::uint64_t{64} << 20;

bool fits(const SealEnd& end, std::uint64_t file_bytes) {
    return end.n_columns <= kMaxColumns && file_bytes >= sizeof end + end.n_columns * sizeof(SealedColumn) &&
           end.body_bytes == file_bytes - sizeof end - end.n_columns * sizeof(SealedColumn);
}

bool read_end(const DiskFile& file, SealEnd& end) {
    const std::uint64_t n = file.size();
    if (n < sizeof end) return false;
    file.read(n - sizeof end, &end, sizeof end);
    return std::memcmp(end.magic, kMagic, sizeof kMagic) == 0;
}

bool starts_as_hdf5(const DiskFile& file) {
    constexpr unsigned char kSignature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
    unsigned char head[8];
    if (file.size() < sizeof head) return false;
    file.read(0, head, sizeof head);
    return std::memcmp(head, kSignature, sizeof head) == 0;
}

} // namespace

const SealedColumn* Seal::find(const std::string& name) const {
    for (const SealedColumn& c : columns)
        if (name == c.name) return &c;
    return nullptr;
}

SealedColumn seal_column(const std::string& name, const Place& place, const core::Digest& digest) {
    SealedColumn c{{}, place, digest};
    TALUS_CHECK(name.size() < sizeof c.name);
    std::copy(name.begin(), name.end(), c.name);
    return c;
}

void add_rows(core::Digest& digest, std::uint64_t row, const std::byte* data, std::size_t row_bytes, std::uint64_t n) {
    switch (row_bytes) {
    case 1: return add_rows_of<1>(digest, row, data, n);
    case 4: return add_rows_of<4>(digest, row, data, n);
    case 8: return add_rows_of<8>(digest, row, data, n);
    case 24: return add_rows_of<24>(digest, row, data, n);
    case 32: return add_rows_of<32>(digest, row, data, n);
    case 64: return add_rows_of<64>(digest, row, data, n);
    default:
        for (std::uint64_t k = 0; k < n; ++k) add_hash(digest, XXH3_128bits_withSeed(data + k * row_bytes, row_bytes, row + k));
    }
}

void write_seal(const DiskFile& file, const FileImage& image, const Seal& seal) {
    SealEnd end{};
    end.body_bytes = image.size();
    end.n_columns = seal.columns.size();
    end.rest = hash_of_rest(seal.columns, image);
    end.format = kCheckpointFormat;
    std::copy(std::begin(kMagic), std::end(kMagic), end.magic);
    end.self = hash_of_seal(seal.columns, end);
    const std::uint64_t columns_bytes = seal.columns.size() * sizeof(SealedColumn);
    file.write(end.body_bytes, seal.columns.data(), columns_bytes);
    file.write(end.body_bytes + columns_bytes, &end, sizeof end);
    file.sync();
    if (!fits(end, file.size())) fail(ErrorKind::io, "{}: has {} bytes after writing, which is not what was written", file.path(), file.size());
}

Seal read_seal(const DiskFile& file, FileImage& out_image) {
    const std::string& path = file.path();
    SealEnd end;
    if (!read_end(file, end)) {
        if (starts_as_hdf5(file)) fail(ErrorKind::io, "{}: is not a whole checkpoint: the commit record at its end is missing. It was cut short or changed after it was written, or is another kind of HDF5 file", path);
        fail(ErrorKind::io, "{}: is not a checkpoint of Talus", path);
    }
    if (end.format != kCheckpointFormat) fail(ErrorKind::io, "{}: has checkpoint format {}; this version of Talus reads format {}", path, end.format, kCheckpointFormat);
    Seal seal;
    bool sound = fits(end, file.size());
    if (sound) {
        seal.columns.resize(end.n_columns);
        file.read(end.body_bytes, seal.columns.data(), seal.columns.size() * sizeof(SealedColumn));
        sound = hash_of_seal(seal.columns, end) == end.self;
    }
    for (const SealedColumn& c : seal.columns) sound = sound && c.name[sizeof c.name - 1] == '\0';
    std::uint64_t rest = 0;
    sound = sound && each_rest(seal.columns, end.body_bytes, [&](std::uint64_t, std::uint64_t n) { rest += n; });
    if (!sound || rest > kMaxRest) fail(ErrorKind::io, "{}: is damaged: its commit record does not agree with itself or with the file's length", path);

    std::vector<std::byte> buffer(std::size_t{1} << 16);
    each_rest(seal.columns, end.body_bytes, [&](std::uint64_t at, std::uint64_t n) {
        for (std::uint64_t done = 0; done < n;) {
            const std::size_t count = std::min<std::uint64_t>(buffer.size(), n - done);
            file.read(at + done, buffer.data(), count);
            out_image.write(at + done, buffer.data(), count);
            done += count;
        }
    });
    out_image.set_size(end.body_bytes);
    if (!(hash_of_rest(seal.columns, out_image) == end.rest)) fail(ErrorKind::io, "{}: is damaged: the bytes that describe its content do not give the stored hash", path);
    return seal;
}

bool has_seal(const std::string& path) {
    const DiskFile file = DiskFile::open_to_read(path);
    SealEnd end;
    return read_end(file, end) && fits(end, file.size());
}

} // namespace talus::runtime
