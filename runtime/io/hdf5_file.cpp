#include "runtime/io/hdf5_file.hpp"

#include <mutex>

#include <hdf5.h>

#include "core/error.hpp"
#include "runtime/io/hdf5_memory.hpp"

namespace talus::runtime {

using core::ErrorKind;
using core::fail;

namespace {

static_assert(std::is_same_v<hid_t, std::int64_t>);

/// Bulk datasets above a page start on one.
constexpr hsize_t kAlignment = 4096;
/// Bytes of a dataset that fit in its header; HDF5 allows a little below 64 KiB.
constexpr std::uint64_t kMaxCompact = 60000;

/// Holds the process-wide lock, and keeps HDF5 from printing for as long; a host's own setting comes back after.
class Session {
public:
    Session() : lock_(guard()) {
        H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
        H5Eclear2(H5E_DEFAULT);
    }
    ~Session() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

private:
    static std::mutex& guard() {
        static std::mutex m;
        return m;
    }
    std::lock_guard<std::mutex> lock_;
    H5E_auto2_t function_ = nullptr;
    void* data_ = nullptr;
};

/// Closes an HDF5 identifier.
class Id {
public:
    Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Id() {
        if (id_ >= 0) close_(id_);
    }
    Id(const Id&) = delete;
    Id& operator=(const Id&) = delete;
    operator hid_t() const { return id_; }
    bool is_open() const { return id_ >= 0; }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/// The innermost of HDF5's messages: the others only say which of its functions passed it on.
std::string words_of_hdf5() {
    std::string text;
    const auto first = [](unsigned, const H5E_error2_t* e, void* out) -> herr_t {
        if (e->desc != nullptr) *static_cast<std::string*>(out) = e->desc;
        return 1;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, first, &text);
    return text.empty() ? "no reason given" : text;
}

hid_t type_of(Kind kind) {
    switch (kind) {
    case Kind::f64: return H5T_IEEE_F64LE;
    case Kind::f32: return H5T_IEEE_F32LE;
    case Kind::i64: return H5T_STD_I64LE;
    case Kind::i32: return H5T_STD_I32LE;
    case Kind::u64: return H5T_STD_U64LE;
    case Kind::u32: return H5T_STD_U32LE;
    case Kind::u8: return H5T_STD_U8LE;
    }
    return -1;
}

Id make_space(const Shape& shape) {
    if (shape.empty()) return {H5Screate(H5S_SCALAR), H5Sclose};
    const std::vector<hsize_t> extents(shape.begin(), shape.end());
    return {H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr), H5Sclose};
}

Shape shape_of(hid_t space) {
    const int n = H5Sget_simple_extent_ndims(space);
    std::vector<hsize_t> extents(static_cast<std::size_t>(n > 0 ? n : 0));
    if (n > 0) H5Sget_simple_extent_dims(space, extents.data(), nullptr);
    return Shape(extents.begin(), extents.end());
}

Id with_parents() {
    const hid_t links = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(links, 1);
    return {links, H5Pclose};
}

/// @param layout  compact or contiguous; without times, so that equal states give equal bytes
Id dataset_creation(H5D_layout_t layout) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_layout(creation, layout);
    H5Pset_obj_track_times(creation, 0);
    H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
    H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
    return {creation, H5Pclose};
}

Id text_type(std::size_t bytes) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, bytes);
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    H5Tset_cset(type, H5T_CSET_ASCII);
    return {type, H5Tclose};
}

bool put_text(hid_t object, const std::string& name, const std::string& text) {
    const Id type = text_type(text.size());
    const Id space(H5Screate(H5S_SCALAR), H5Sclose);
    const Id attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    return attribute.is_open() && H5Awrite(attribute, type, text.data()) >= 0;
}

} // namespace

std::size_t size_of(Kind kind) {
    switch (kind) {
    case Kind::f64:
    case Kind::i64:
    case Kind::u64: return 8;
    case Kind::f32:
    case Kind::i32:
    case Kind::u32: return 4;
    case Kind::u8: return 1;
    }
    return 0;
}

std::uint64_t items_of(const Shape& shape) {
    std::uint64_t n = 1;
    for (const std::uint64_t extent : shape) n *= extent;
    return n;
}

void Hdf5File::raise(const std::string& what) const { fail(ErrorKind::io, "{}: {} (HDF5: {})", name_, what, words_of_hdf5()); }

Hdf5File::Hdf5File(std::string name) : name_(std::move(name)), image_(std::make_unique<FileImage>()) {
    const Session session;
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (!access.is_open() || !use_image(access, *image_) || H5Pset_alignment(access, kAlignment, kAlignment) < 0) raise("cannot set HDF5 up");
    file_ = H5Fcreate(name_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
    if (file_ < 0) raise("cannot be laid out");
}

Hdf5File::Hdf5File(std::string name, FileImage image) : name_(std::move(name)), image_(std::make_unique<FileImage>(std::move(image))) {
    const Session session;
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (!access.is_open() || !use_image(access, *image_)) raise("cannot set HDF5 up");
    file_ = H5Fopen(name_.c_str(), H5F_ACC_RDONLY, access);
    if (file_ < 0) raise("is not an HDF5 file");
}

Hdf5File::~Hdf5File() {
    if (file_ < 0) return;
    const Session session;
    H5Fclose(file_);
}

FileImage Hdf5File::finish() {
    const Session session;
    const hid_t file = file_;
    file_ = -1;
    if (H5Fclose(file) < 0) raise("cannot be closed");
    return std::move(*image_);
}

void Hdf5File::add_group(const std::string& path) {
    const Session session;
    const Id links = with_parents();
    const Id group(H5Gcreate2(file_, path.c_str(), links, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    if (!group.is_open()) raise("group " + path + " cannot be made");
}

void Hdf5File::add_link(const std::string& target, const std::string& path) {
    const Session session;
    const Id links = with_parents();
    if (H5Lcreate_soft(target.c_str(), file_, path.c_str(), links, H5P_DEFAULT) < 0) raise("link " + path + " cannot be made");
}

void Hdf5File::add_attribute(const std::string& object, const std::string& name, Kind kind, const Shape& shape, const void* data) {
    const Session session;
    const Id holder(H5Oopen(file_, object.c_str(), H5P_DEFAULT), H5Oclose);
    if (!holder.is_open()) raise("object " + object + " cannot be opened");
    const Id space = make_space(shape);
    const Id attribute(H5Acreate2(holder, name.c_str(), type_of(kind), space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (!attribute.is_open() || H5Awrite(attribute, type_of(kind), data) < 0) raise("attribute " + name + " of " + object + " cannot be written");
}

void Hdf5File::add_text(const std::string& object, const std::string& name, const std::string& text) {
    const Session session;
    const Id holder(H5Oopen(file_, object.c_str(), H5P_DEFAULT), H5Oclose);
    if (!holder.is_open()) raise("object " + object + " cannot be opened");
    if (!put_text(holder, name, text)) raise("attribute " + name + " of " + object + " cannot be written");
}

void Hdf5File::add_dataset(const std::string& path, Kind kind, const Shape& shape, const void* data, const std::string& unit) {
    const Session session;
    const bool compact = items_of(shape) * size_of(kind) <= kMaxCompact;
    const Id links = with_parents(), creation = dataset_creation(compact ? H5D_COMPACT : H5D_CONTIGUOUS), space = make_space(shape);
    const Id set(H5Dcreate2(file_, path.c_str(), type_of(kind), space, links, creation, H5P_DEFAULT), H5Dclose);
    if (!set.is_open() || H5Dwrite(set, type_of(kind), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) raise("dataset " + path + " cannot be written");
    if (!unit.empty() && !put_text(set, "unit", unit)) raise("the unit of dataset " + path + " cannot be written");
}

Place Hdf5File::reserve(const std::string& path, Kind kind, const Shape& shape, const std::string& unit) {
    TALUS_CHECK(shape.size() == 1 || shape.size() == 2);
    const Session session;
    const Id links = with_parents(), creation = dataset_creation(H5D_CONTIGUOUS), space = make_space(shape);
    const Id set(H5Dcreate2(file_, path.c_str(), type_of(kind), space, links, creation, H5P_DEFAULT), H5Dclose);
    if (!set.is_open()) raise("dataset " + path + " cannot be made");
    if (!unit.empty() && !put_text(set, "unit", unit)) raise("the unit of dataset " + path + " cannot be written");
    Place place{0, shape[0], size_of(kind) * (shape.size() == 2 ? shape[1] : 1)};
    if (place.rows > 0 && (place.offset = H5Dget_offset(set)) == HADDR_UNDEF) raise("dataset " + path + " has no place");
    return place;
}

bool Hdf5File::has(const std::string& path) const {
    const Session session;
    // H5Lexists fails where a parent is missing: asked for one by one.
    for (std::size_t slash = path.find('/', 1);; slash = path.find('/', slash + 1)) {
        if (H5Lexists(file_, path.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
        if (slash == std::string::npos) return true;
    }
}

Place Hdf5File::find(const std::string& path, Kind kind, std::uint64_t columns) const {
    const Session session;
    const Id set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!set.is_open()) raise("dataset " + path + " is missing");
    const Id space(H5Dget_space(set), H5Sclose), type(H5Dget_type(set), H5Tclose), creation(H5Dget_create_plist(set), H5Pclose);
    const Shape shape = shape_of(space);
    const bool fits = columns == 0 ? shape.size() == 1 : shape.size() == 2 && shape[1] == columns;
    if (!fits || H5Tequal(type, type_of(kind)) <= 0) fail(ErrorKind::io, "{}: dataset {} has not the type or the columns it should have", name_, path);
    if (H5Pget_layout(creation) != H5D_CONTIGUOUS || H5Pget_external_count(creation) != 0) fail(ErrorKind::io, "{}: dataset {} is not stored in one piece", name_, path);
    Place place{0, shape[0], size_of(kind) * (columns == 0 ? 1 : columns)};
    if (place.rows > 0 && (place.offset = H5Dget_offset(set)) == HADDR_UNDEF) raise("dataset " + path + " has no data");
    return place;
}

void Hdf5File::read_dataset(const std::string& path, Kind kind, const Shape& shape, void* out) const {
    const Session session;
    const Id set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!set.is_open()) raise("dataset " + path + " is missing");
    const Id space(H5Dget_space(set), H5Sclose), type(H5Dget_type(set), H5Tclose);
    if (shape_of(space) != shape || H5Tequal(type, type_of(kind)) <= 0) fail(ErrorKind::io, "{}: dataset {} has not the type or the shape it should have", name_, path);
    if (H5Dread(set, type_of(kind), H5S_ALL, H5S_ALL, H5P_DEFAULT, out) < 0) raise("dataset " + path + " cannot be read");
}

void Hdf5File::read_attribute(const std::string& object, const std::string& name, Kind kind, const Shape& shape, void* out) const {
    const Session session;
    const Id attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (!attribute.is_open()) raise("attribute " + name + " of " + object + " is missing");
    const Id space(H5Aget_space(attribute), H5Sclose), type(H5Aget_type(attribute), H5Tclose);
    if (shape_of(space) != shape || H5Tequal(type, type_of(kind)) <= 0) fail(ErrorKind::io, "{}: attribute {} of {} has not the type or the shape it should have", name_, name, object);
    if (H5Aread(attribute, type_of(kind), out) < 0) raise("attribute " + name + " of " + object + " cannot be read");
}

std::string Hdf5File::read_text(const std::string& object, const std::string& name) const {
    const Session session;
    const Id attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (!attribute.is_open()) raise("attribute " + name + " of " + object + " is missing");
    const Id space(H5Aget_space(attribute), H5Sclose), type(H5Aget_type(attribute), H5Tclose);
    if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 || H5Sget_simple_extent_npoints(space) != 1)
        fail(ErrorKind::io, "{}: attribute {} of {} is not a fixed-length text", name_, name, object);
    std::string text(H5Tget_size(type), '\0');
    if (H5Aread(attribute, type, text.data()) < 0) raise("attribute " + name + " of " + object + " cannot be read");
    return text;
}

} // namespace talus::runtime
