// The layer over HDF5: what it writes is an HDF5 file like any other, its failures are errors with a text, and nothing is printed.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <hdf5.h>

#include "core/error.hpp"
#include "runtime/io/disk_file.hpp"
#include "runtime/io/hdf5_file.hpp"

namespace talus::runtime {
namespace {

namespace fs = std::filesystem;

class Hdf5FileTest : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("talus_hdf5_" + std::to_string(::getpid()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string path(const char* name) const { return folder_ / name; }

    static void write_image(const std::string& to, const FileImage& image) {
        const DiskFile disk = DiskFile::create(to);
        disk.resize(image.size());
        image.each_page([&](std::uint64_t at, const std::byte* data, std::size_t n) { disk.write(at, data, n); });
    }
    static FileImage read_image(const std::string& from) {
        const DiskFile disk = DiskFile::open_to_read(from);
        std::vector<std::byte> bytes(disk.size());
        disk.read(0, bytes.data(), bytes.size());
        FileImage image;
        image.write(0, bytes.data(), bytes.size());
        return image;
    }

    fs::path folder_;
};

template <class Action>
std::string message_of(Action action) {
    try {
        action();
    } catch (const core::Error& e) {
        EXPECT_EQ(e.kind(), core::ErrorKind::io);
        return e.what();
    }
    ADD_FAILURE() << "no error";
    return {};
}

TEST_F(Hdf5FileTest, small_values_come_back) {
    const double gravity[3] = {0.0, -9.81, 1e-300};
    const std::int64_t step = -7;
    const std::uint64_t seed = ~std::uint64_t{0};
    Hdf5File out("a.hdf");
    out.add_dataset("/state/deep/gravity", Kind::f64, {3}, gravity, "m/s^2");
    out.add_dataset("/state/step", Kind::i64, {}, &step);
    out.add_attribute("/state", "seed", Kind::u64, {}, &seed);
    out.add_text("/state", "kind", "of text");
    out.add_link("/state/step", "/links/step");

    const Hdf5File in("a.hdf", out.finish());
    double g[3];
    in.read_dataset("/state/deep/gravity", Kind::f64, {3}, g);
    EXPECT_TRUE(std::equal(g, g + 3, gravity));
    EXPECT_EQ(in.read_text("/state/deep/gravity", "unit"), "m/s^2");
    std::int64_t n = 0;
    in.read_dataset("/links/step", Kind::i64, {}, &n);
    EXPECT_EQ(n, step);
    std::uint64_t u = 0;
    in.read_attribute("/state", "seed", Kind::u64, {}, &u);
    EXPECT_EQ(u, seed);
    EXPECT_EQ(in.read_text("/state", "kind"), "of text");
    EXPECT_TRUE(in.has("/state/deep"));
    EXPECT_TRUE(in.has("/links/step"));
    EXPECT_FALSE(in.has("/state/shallow/gravity"));
}

TEST_F(Hdf5FileTest, bulk_written_at_its_place_is_read_by_hdf5) {
    std::vector<double> rows(3 * 5000);
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = 0.1 * static_cast<double>(k);
    Hdf5File out("bulk");
    const Place none = out.reserve("/bulk/empty", Kind::i64, {0});
    const Place place = out.reserve("/bulk/rows", Kind::f64, {5000, 3}, "m");
    EXPECT_EQ(none.rows, 0u);
    EXPECT_EQ(place.row_bytes, 24u);
    EXPECT_EQ(place.offset % 4096, 0u);
    const FileImage image = out.finish();
    EXPECT_GE(image.size(), place.offset + place.rows * place.row_bytes);
    write_image(path("bulk.hdf"), image);
    {
        const DiskFile disk = DiskFile::open_to_write(path("bulk.hdf"));
        disk.write(place.offset, rows.data(), rows.size() * sizeof(double));
        // HDF5 does not mind what stands after its end: that is where a checkpoint's seal goes.
        disk.write(disk.size(), "trailing bytes", 14);
    }
    const hid_t file = H5Fopen(path("bulk.hdf").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    const hid_t set = H5Dopen2(file, "/bulk/rows", H5P_DEFAULT);
    ASSERT_GE(set, 0);
    std::vector<double> back(rows.size());
    EXPECT_GE(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, back.data()), 0);
    EXPECT_EQ(back, rows);
    H5Dclose(set);
    H5Fclose(file);

    const Hdf5File in("bulk.hdf", read_image(path("bulk.hdf")));
    const Place found = in.find("/bulk/rows", Kind::f64, 3);
    EXPECT_EQ(found.offset, place.offset);
    EXPECT_EQ(found.rows, 5000u);
}

TEST_F(Hdf5FileTest, equal_content_gives_equal_bytes) {
    for (const char* name : {"one", "two"}) {
        Hdf5File out("same name");
        const double x = 1.5;
        out.add_dataset("/a/x", Kind::f64, {}, &x, "m");
        out.reserve("/b", Kind::f32, {100000, 3});
        write_image(path(name), out.finish());
    }
    std::ifstream one(path("one"), std::ios::binary), two(path("two"), std::ios::binary);
    EXPECT_TRUE(std::equal(std::istreambuf_iterator<char>(one), {}, std::istreambuf_iterator<char>(two), {}));
}

TEST_F(Hdf5FileTest, long_tables_of_ranks_fit) {
    const std::vector<std::int64_t> counts(16384, 3);
    Hdf5File out("ranks");
    out.add_dataset("/counts", Kind::i64, {counts.size()}, counts.data());
    const Hdf5File in("ranks", out.finish());
    std::vector<std::int64_t> back(counts.size());
    in.read_dataset("/counts", Kind::i64, {back.size()}, back.data());
    EXPECT_EQ(back, counts);
}

TEST_F(Hdf5FileTest, errors_name_file_object_and_reason_and_print_nothing) {
    testing::internal::CaptureStderr();
    Hdf5File out("some.hdf");
    const double x = 1.0;
    out.add_dataset("/x", Kind::f64, {}, &x);
    const std::string twice = message_of([&] { out.add_dataset("/x", Kind::f64, {}, &x); });
    EXPECT_NE(twice.find("some.hdf: dataset /x cannot be written (HDF5: "), std::string::npos) << twice;
    const Hdf5File in("other.hdf", out.finish());
    double y[2];
    std::int32_t i = 0;
    EXPECT_NE(message_of([&] { in.read_dataset("/y", Kind::f64, {}, y); }).find("dataset /y is missing"), std::string::npos);
    EXPECT_NE(message_of([&] { in.read_dataset("/x", Kind::f64, {2}, y); }).find("has not the type or the shape"), std::string::npos);
    EXPECT_NE(message_of([&] { in.read_dataset("/x", Kind::i32, {}, &i); }).find("has not the type or the shape"), std::string::npos);
    EXPECT_NE(message_of([&] { in.find("/x", Kind::f64, 3); }).find("has not the type or the columns"), std::string::npos);
    EXPECT_NE(message_of([&] { in.read_text("/", "name"); }).find("attribute name of / is missing"), std::string::npos);
    FileImage noise;
    noise.write(0, "not an HDF5 file, whatever its name says", 40);
    EXPECT_NE(message_of([&] { Hdf5File("noise.hdf", std::move(noise)); }).find("noise.hdf: is not an HDF5 file (HDF5: "), std::string::npos);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(Hdf5FileTest, two_files_may_be_open_at_once) {
    Hdf5File a("same"), b("same");
    const std::int64_t one = 1, two = 2;
    a.add_dataset("/n", Kind::i64, {}, &one);
    b.add_dataset("/n", Kind::i64, {}, &two);
    const Hdf5File from_a("same", a.finish()), from_b("same", b.finish());
    std::int64_t n = 0;
    from_a.read_dataset("/n", Kind::i64, {}, &n);
    EXPECT_EQ(n, 1);
    from_b.read_dataset("/n", Kind::i64, {}, &n);
    EXPECT_EQ(n, 2);
}

TEST_F(Hdf5FileTest, disk_errors_name_the_file_and_the_reason) {
    EXPECT_EQ(message_of([&] { DiskFile::open_to_read(path("absent")); }), path("absent") + ": cannot be opened: No such file or directory");
    EXPECT_EQ(message_of([&] { DiskFile::create(path("absent/file")); }), path("absent/file") + ": cannot be created: No such file or directory");
    EXPECT_EQ(message_of([&] { DiskFile::open_to_read(folder_); }), folder_.string() + ": is not a regular file");
    const DiskFile file = DiskFile::create(path("short"));
    file.write(0, "abc", 3);
    char bytes[4];
    EXPECT_NE(message_of([&] { file.read(0, bytes, 4); }).find("it was cut short"), std::string::npos);
}

TEST_F(Hdf5FileTest, a_new_file_takes_the_place_of_the_old_one_and_keeps_it) {
    const std::string target = path("state");
    const auto content = [](const std::string& file) {
        std::ifstream in(file);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    for (const char* text : {"1", "2", "3"}) {
        DiskFile::create(partial_name(target)).write(0, text, 1);
        put_in_place(target, true);
    }
    EXPECT_EQ(content(target), "3");
    EXPECT_EQ(content(previous_name(target)), "2");
    DiskFile::create(partial_name(target)).write(0, "4", 1);
    put_in_place(target, false);
    EXPECT_EQ(content(target), "4");
    EXPECT_EQ(content(previous_name(target)), "2");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
}

} // namespace
} // namespace talus::runtime
