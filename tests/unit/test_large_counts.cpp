// Billions of grains: what is counted, labelled and written must not know where 32 bits end. Files are sparse, beds are not filled.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "core/packing.hpp"
#include "core/state_digest.hpp"
#include "runtime/io/checkpoint_layout.hpp"
#include "runtime/io/vtkhdf.hpp"

namespace talus::runtime {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kGrainsOfPaper = 2'400'000'000;
constexpr int kRanks = 16384;

TEST(LargeCounts, rows_of_thousands_of_ranks_follow_each_other_without_a_gap) {
    std::vector<std::int64_t> counts(kRanks, kGrainsOfPaper / kRanks);
    counts.back() += kGrainsOfPaper % kRanks;
    std::uint64_t next = 0;
    for (int r = 0; r < kRanks; r += 63) {
        const Rows rows = rows_in_rank_order(counts, r);
        EXPECT_EQ(rows.first, static_cast<std::uint64_t>(r) * (kGrainsOfPaper / kRanks));
        EXPECT_GE(rows.first, next);
        EXPECT_EQ(rows.total, static_cast<std::uint64_t>(kGrainsOfPaper));
        next = rows.first + rows.count;
    }
}

TEST(LargeCounts, a_checkpoint_of_billions_of_grains_is_written_and_read_at_its_ends) {
    // One rank's thousand rows at the very end of 2.4e9, and as many at the start: the file is some 500 GB long and a few MB large.
    const std::string path = fs::temp_directory_path() / ("talus_large_" + std::to_string(::getpid()));
    constexpr std::uint64_t kRows = 1000;
    std::vector<core::Particle> grains(kRows), back(kRows);
    std::vector<core::Reference> references(kRows), references_back(kRows);
    std::vector<core::ForceSum> sums(kRows), sums_back(kRows);
    Workers workers(2);
    for (const std::uint64_t first : {std::uint64_t{0}, static_cast<std::uint64_t>(kGrainsOfPaper) - kRows}) {
        const Rows rows{first, kRows, static_cast<std::uint64_t>(kGrainsOfPaper)};
        for (std::uint64_t k = 0; k < kRows; ++k) {
            grains[k].label = static_cast<core::Label>(first + k);
            for (int a = 0; a < 3; ++a) grains[k].position[a] = static_cast<double>(first + k) + 0.25 * a;
            sums[k].force[2] = -static_cast<std::int64_t>(first + k);
        }
        std::vector<Column> out = grain_columns({grains.data(), references.data(), sums.data()}, rows, true), in = grain_columns({back.data(), references_back.data(), sums_back.data()}, rows, false);
        Hdf5File layout("large.ckpt");
        std::vector<Place> places;
        for (const Column& c : out) places.push_back(layout.reserve(c.name, c.kind, c.width == 0 ? Shape{c.rows.total} : Shape{c.rows.total, c.width}));
        FileImage image = layout.finish();
        EXPECT_GT(image.size(), static_cast<std::uint64_t>(kGrainsOfPaper) * 150);
        {
            const DiskFile disk = first == 0 ? DiskFile::create(path) : DiskFile::open_to_write(path);
            disk.resize(image.size());
            image.each_page([&](std::uint64_t at, const std::byte* data, std::size_t n) { disk.write(at, data, n); });
            const std::vector<core::Digest> written = write_rows(workers, disk, out, places);
            const DiskFile reader = DiskFile::open_to_read(path);
            const std::vector<core::Digest> read = read_rows(workers, reader, in, places);
            for (std::size_t c = 0; c < written.size(); ++c) EXPECT_TRUE(written[c].lo == read[c].lo && written[c].hi == read[c].hi) << out[c].name;
        }
        // HDF5 finds the same places in what it laid out.
        const Hdf5File found("large.ckpt", std::move(image));
        const Place position = found.find("/grains/position", Kind::f64, 3);
        EXPECT_EQ(position.rows, static_cast<std::uint64_t>(kGrainsOfPaper));
        const DiskFile reader = DiskFile::open_to_read(path);
        double x[3];
        reader.read(position.offset + (first + 17) * position.row_bytes, x, sizeof x);
        EXPECT_EQ(x[0], static_cast<double>(first + 17));
        for (std::uint64_t k = 0; k < kRows; ++k) {
            EXPECT_EQ(back[k].label, grains[k].label);
            EXPECT_EQ(back[k].position[2], grains[k].position[2]);
            EXPECT_EQ(sums_back[k].force[2], sums[k].force[2]);
        }
    }
    EXPECT_GT(fs::file_size(path), std::uint64_t{1} << 38);
    fs::remove(path);
}

TEST(LargeCounts, a_lattice_of_billions_of_places_has_each_grain_in_its_own) {
    core::FillPlan plan{};
    const double hi[3] = {1.0, 0.05, 1.0};
    for (int a = 0; a < 3; ++a) plan.hi[a] = hi[a];
    plan.radius_min = 1.0e-4;
    plan.radius_max = 1.1e-4;
    core::plan_lattice(plan);
    ASSERT_GT(plan.n_places(), kGrainsOfPaper);
    for (const std::int64_t place : {std::int64_t{5}, (std::int64_t{1} << 31) + 5, (std::int64_t{1} << 31) - 1, kGrainsOfPaper - 1, plan.n_places() - 1}) {
        const core::FilledGrain g = core::grain_at(plan, place);
        std::int64_t at[3];
        for (int a = 0; a < 3; ++a) {
            EXPECT_GE(g.position[a], plan.lo[a] + g.radius);
            EXPECT_LE(g.position[a], plan.hi[a] - g.radius);
            at[a] = static_cast<std::int64_t>((g.position[a] - plan.lo[a]) / plan.spacing[a]);
        }
        // Layer by layer along y, then z, then x.
        EXPECT_EQ((at[1] * plan.places[0] + at[0]) * plan.places[2] + at[2], place);
    }
}

TEST(LargeCounts, energies_of_billions_of_grains_fit_their_sums) {
    // The largest that one grain may have at all is a contact at the cap over the largest radius: 2^k units; sums are of 2^40 finer ones.
    const double most = core::kCapUnits * 0x1p40 * static_cast<double>(kGrainsOfPaper);
    EXPECT_LT(most, 0x1p127);
}

} // namespace
} // namespace talus::runtime
