#include "runtime/io/columns.hpp"

#include <mutex>
#include <numeric>
#include <optional>

#include "runtime/io/seal.hpp"

namespace talus::runtime {

namespace {

constexpr std::uint64_t kBlock = 8192; // rows moved at once: their grains stay in the cache from column to column

/// step(column, first row of this rank, rows, buffer) for blocks of rows of all columns, on the workers; columns of equal length
/// go together.
template <class Step>
std::vector<core::Digest> each_block(Workers& workers, const std::vector<Column>& columns, Step step) {
    std::vector<core::Digest> sums(columns.size());
    std::mutex guard;
    std::vector<std::vector<std::byte>> buffers(static_cast<std::size_t>(workers.threads()));
    for (std::size_t from = 0, to; from < columns.size(); from = to) {
        const std::uint64_t count = columns[from].rows.count;
        for (to = from + 1; to < columns.size() && columns[to].rows.count == count;) ++to;
        workers.for_each(Phase::observe, static_cast<int>((count + kBlock - 1) / kBlock), [&](int block) {
            const std::uint64_t row = static_cast<std::uint64_t>(block) * kBlock, n = std::min(kBlock, count - row);
            std::vector<std::byte>& buffer = buffers[static_cast<std::size_t>(Workers::current())];
            buffer.resize(kBlock * kMaxRowBytes);
            std::vector<core::Digest> mine(to - from);
            for (std::size_t c = from; c < to; ++c) {
                const std::size_t bytes = columns[c].row_bytes();
                TALUS_CHECK(bytes <= kMaxRowBytes);
                step(c, row, n, buffer.data());
                add_rows(mine[c - from], columns[c].rows.first + row, buffer.data(), bytes, n);
            }
            const std::lock_guard lock(guard);
            for (std::size_t c = from; c < to; ++c) {
                sums[c].lo += mine[c - from].lo;
                sums[c].hi += mine[c - from].hi;
            }
        });
    }
    return sums;
}

std::uint64_t offset_of(const Place& place, const Column& column, std::uint64_t row) { return place.offset + (column.rows.first + row) * place.row_bytes; }

/// Rank 0: the file under its partial name with all but the bulk.
FileImage start_file(const NewFile& file, std::vector<Place>& places) {
    Hdf5File hdf5(file.path);
    file.lay_out(hdf5);
    for (std::size_t c = 0; c < file.columns.size(); ++c) {
        const Column& column = file.columns[c];
        places[c] = hdf5.reserve(column.name, column.kind, column.width == 0 ? Shape{column.rows.total} : Shape{column.rows.total, column.width}, column.unit);
    }
    FileImage image = hdf5.finish();
    const DiskFile disk = DiskFile::create(partial_name(file.path));
    disk.reserve(image.size());
    disk.resize(image.size());
    image.each_page([&](std::uint64_t at, const std::byte* data, std::size_t n) { disk.write(at, data, n); });
    return image;
}

/// Rank 0: what makes the file whole.
void finish_file(const NewFile& file, DiskFile& disk, const FileImage& image, const std::vector<Place>& places, const std::vector<core::Digest>& digests) {
    if (file.sealed) {
        Seal seal;
        for (std::size_t c = 0; c < places.size(); ++c) seal.columns.push_back(seal_column(file.columns[c].name, places[c], digests[c]));
        write_seal(disk, image, seal);
    }
    disk.close();
    // What is not whole itself does not push out a whole one before it.
    const bool keep = file.sealed && file_exists(file.path) && (has_seal(file.path) || !file_exists(previous_name(file.path)));
    put_in_place(file.path, keep);
}

} // namespace

std::vector<std::int64_t> count_by_rank(Communicator& comm, std::uint64_t mine) {
    std::vector<std::int64_t> counts(static_cast<std::size_t>(comm.size()), 0);
    counts[static_cast<std::size_t>(comm.rank())] = static_cast<std::int64_t>(mine);
    comm.sum(counts);
    return counts;
}

Rows rows_in_rank_order(const std::vector<std::int64_t>& counts, int rank) {
    const auto total = [&](int ranks) { return static_cast<std::uint64_t>(std::accumulate(counts.begin(), counts.begin() + ranks, std::int64_t{0})); };
    return {total(rank), static_cast<std::uint64_t>(counts[static_cast<std::size_t>(rank)]), total(static_cast<int>(counts.size()))};
}

Rows share_of_rows(const Communicator& comm, std::uint64_t total) {
    // 128 bits: rows times ranks may pass 2^64.
    const auto before = [&](int r) { return static_cast<std::uint64_t>(static_cast<unsigned __int128>(total) * static_cast<unsigned>(r) / static_cast<unsigned>(comm.size())); };
    const std::uint64_t first = before(comm.rank());
    return {first, before(comm.rank() + 1) - first, total};
}

std::vector<core::Digest> write_rows(Workers& workers, const DiskFile& file, const std::vector<Column>& columns, const std::vector<Place>& places) {
    return each_block(workers, columns, [&](std::size_t c, std::uint64_t row, std::uint64_t n, std::byte* buffer) {
        columns[c].move(row, n, buffer);
        file.write(offset_of(places[c], columns[c], row), buffer, n * places[c].row_bytes);
    });
}

std::vector<core::Digest> read_rows(Workers& workers, const DiskFile& file, const std::vector<Column>& columns, const std::vector<Place>& places) {
    return each_block(workers, columns, [&](std::size_t c, std::uint64_t row, std::uint64_t n, std::byte* buffer) {
        file.read(offset_of(places[c], columns[c], row), buffer, n * places[c].row_bytes);
        columns[c].move(row, n, buffer);
    });
}

void sum_over_ranks(Communicator& comm, std::vector<core::Digest>& digests) {
    for (core::Digest& d : digests) {
        d.lo = comm.sum_modulo(d.lo);
        d.hi = comm.sum_modulo(d.hi);
    }
}

void write_file(EngineState& s, const NewFile& file) {
    Communicator& comm = *s.comm;
    const bool first = comm.rank() == 0;
    std::vector<Place> places(file.columns.size());
    std::vector<core::Digest> digests;
    FileImage image;
    try {
        agree(comm, [&] {
            if (first) image = start_file(file, places);
        });
        comm.broadcast(places.data(), places.size() * sizeof(Place), 0);
        std::optional<DiskFile> disk;
        agree(comm, [&] {
            disk = DiskFile::open_to_write(partial_name(file.path));
            digests = write_rows(s.workers, *disk, file.columns, places);
            disk->sync();
            if (!first) disk->close();
        });
        sum_over_ranks(comm, digests);
        agree(comm, [&] {
            if (first) finish_file(file, *disk, image, places, digests);
        });
    } catch (...) {
        if (first) remove_file(partial_name(file.path));
        throw;
    }
}

} // namespace talus::runtime
