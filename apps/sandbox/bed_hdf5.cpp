// bed_hdf5.cpp: the HDF5 format of bed files. The engine uses HDF5 too; it has none of its files open while this runs.
#include <hdf5.h>

#include <fmt/format.h>

#include "bed_file.hpp"

namespace talus::sandbox {

namespace {

// Closes an HDF5 identifier. HDF5 would otherwise keep the file open.
class Handle {
public:
    Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Handle() {
        if (id_ >= 0) close_(id_);
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    operator hid_t() const { return id_; }
    bool is_open() const { return id_ >= 0; }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

// HDF5 prints a stack of its errors unless told not to; ours are in the list of faults.
class Silence {
public:
    Silence() {
        H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~Silence() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;

private:
    H5E_auto2_t function_ = nullptr;
    void* data_ = nullptr;
};

// The shape of a dataset or attribute, or nothing if it is no array of numbers.
std::vector<hsize_t> shape_of(hid_t space) {
    const int rank = H5Sget_simple_extent_ndims(space);
    std::vector<hsize_t> shape(static_cast<std::size_t>(std::max(rank, 0)));
    if (rank > 0) H5Sget_simple_extent_dims(space, shape.data(), nullptr);
    return shape;
}

bool is_number(hid_t type) {
    const H5T_class_t kind = H5Tget_class(type);
    return kind == H5T_INTEGER || kind == H5T_FLOAT;
}

template <class T>
void read_dataset(hid_t file, const std::string& path, const char* name, hsize_t columns, hid_t memory_type, std::vector<T>& out,
                  Faults& faults) {
    const Handle set(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
    if (!set.is_open()) {
        faults.add(fmt::format("{}: has no dataset {}; a bed has id, position and radius", path, name));
        return;
    }
    const Handle space(H5Dget_space(set), H5Sclose);
    const Handle type(H5Dget_type(set), H5Tclose);
    const std::vector<hsize_t> shape = shape_of(space);
    const bool fits = columns == 1 ? shape.size() == 1 : shape.size() == 2 && shape[1] == columns;
    if (!fits || !is_number(type)) {
        faults.add(
            fmt::format("{}: dataset {} must be numbers of shape [N{}]", path, name, columns == 1 ? "" : fmt::format(" x {}", columns)));
        return;
    }
    out.resize(shape[0] * columns);
    if (H5Dread(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, out.data()) < 0) {
        out.clear();
        faults.add(fmt::format("{}: dataset {} cannot be read; the file is damaged", path, name));
    }
}

// An attribute of n numbers; false if it is not there or something else.
bool read_attribute(hid_t file, const char* name, hsize_t n, double* out) {
    const Handle attribute(H5Aopen(file, name, H5P_DEFAULT), H5Aclose);
    if (!attribute.is_open()) return false;
    const Handle space(H5Aget_space(attribute), H5Sclose);
    const Handle type(H5Aget_type(attribute), H5Tclose);
    return shape_of(space) == std::vector<hsize_t>{n} && is_number(type) && H5Aread(attribute, H5T_NATIVE_DOUBLE, out) >= 0;
}

void read_box(hid_t file, const std::string& path, bool is_snapshot, RawBed& raw, Faults& faults) {
    double ends[6];
    if (is_snapshot)
        raw.has_box = read_attribute(file, "box_lo", 3, raw.bed.lo.data()) && read_attribute(file, "box_hi", 3, raw.bed.hi.data());
    else if ((raw.has_box = read_attribute(file, "box", 6, ends)))
        for (int axis = 0; axis < 3; ++axis) {
            raw.bed.lo[axis] = ends[2 * axis];
            raw.bed.hi[axis] = ends[2 * axis + 1];
        }
    if (!raw.has_box)
        faults.add(fmt::format("{}: has no attribute{}", path, is_snapshot ? "s box_lo and box_hi of three numbers in m" : " box of six numbers, xlo xhi ylo yhi zlo zhi in m"));
}

} // namespace

RawBed read_bed_hdf5(const std::string& path, Faults& faults) {
    const Silence silence;
    RawBed raw;
    const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (!file.is_open()) {
        faults.add(fmt::format("{}: is damaged or not a whole HDF5 file", path));
        return raw;
    }
    const bool is_snapshot = H5Lexists(file, "VTKHDF", H5P_DEFAULT) > 0;
    read_box(file, path, is_snapshot, raw, faults);
    Bed& bed = raw.bed;
    read_dataset(file, path, is_snapshot ? "VTKHDF/PointData/label" : "id", 1, H5T_NATIVE_INT64, bed.label, faults);
    read_dataset(file, path, is_snapshot ? "VTKHDF/Points" : "position", 3, H5T_NATIVE_DOUBLE, bed.position, faults);
    read_dataset(file, path, is_snapshot ? "VTKHDF/PointData/radius" : "radius", 1, H5T_NATIVE_DOUBLE, bed.radius, faults);
    if (bed.position.size() != 3 * bed.label.size() || bed.radius.size() != bed.label.size()) {
        if (!bed.label.empty() && !bed.position.empty() && !bed.radius.empty())
            faults.add(fmt::format("{}: {} ids, {} positions and {} radii; there must be one of each a grain", path, bed.label.size(),
                                   bed.position.size() / 3, bed.radius.size()));
        bed = Bed{bed.lo, bed.hi, {}, {}, {}, {}};
    }
    return raw;
}

} // namespace talus::sandbox
