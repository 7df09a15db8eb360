// runtime/io/columns.hpp: bulk datasets, a row a grain or a contact. Every rank moves its own rows, all at once; a rank without
// rows takes part like the others.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/state_digest.hpp"
#include "runtime/engine_state.hpp"
#include "runtime/io/disk_file.hpp"
#include "runtime/io/hdf5_file.hpp"

namespace talus::runtime {

/// The rows of a table that belong to this rank, and where they stand among those of all ranks.
struct Rows {
    std::uint64_t first = 0, count = 0, total = 0;
};

/// How many rows each rank has. [collective]
std::vector<std::int64_t> count_by_rank(Communicator& comm, std::uint64_t mine);
/// The rows of a rank when the ranks' rows stand in rank order.
Rows rows_in_rank_order(const std::vector<std::int64_t>& counts, int rank);
/// Equal shares of rows.
Rows share_of_rows(const Communicator& comm, std::uint64_t total);

struct Column {
    std::string name; // path in the file
    std::string unit;
    Kind kind;
    std::uint64_t width = 0; // values a row; 0: a plain list
    Rows rows;
    /// Writing: fill `bytes` with rows [row, row + n) of this rank. Reading: take them from there. Called from several threads.
    std::function<void(std::uint64_t row, std::uint64_t n, std::byte* bytes)> move;

    std::size_t row_bytes() const { return size_of(kind) * (width == 0 ? 1 : width); }
};

/// Write this rank's rows of all columns. @return for each the digest of these rows
std::vector<core::Digest> write_rows(Workers& workers, const DiskFile& file, const std::vector<Column>& columns, const std::vector<Place>& places);
/// Read this rank's rows of all columns. @return for each the digest of these rows
std::vector<core::Digest> read_rows(Workers& workers, const DiskFile& file, const std::vector<Column>& columns, const std::vector<Place>& places);
/// Digests of whole columns from those of the ranks' rows. [collective]
void sum_over_ranks(Communicator& comm, std::vector<core::Digest>& digests);

struct NewFile {
    std::string path;
    std::vector<Column> columns;
    /// Groups, attributes and small datasets beside the columns; called on rank 0.
    std::function<void(Hdf5File&)> lay_out;
    bool sealed = false; // ends in a commit record, and the file that stood there is kept
};

/// Write a file under its partial name and put it in place when it is whole on the disk. On failure every rank throws the same
/// error, and what stood there stands there still. [collective]
void write_file(EngineState& s, const NewFile& file);

} // namespace talus::runtime
