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

void read_box(hid_t file, const std::string& path, RawBed& raw, Faults& faults) {
    const Handle box(H5Aopen(file, "box", H5P_DEFAULT), H5Aclose);
    double numbers[6];
    bool good = box.is_open();
    if (good) {
        const Handle space(H5Aget_space(box), H5Sclose);
        const Handle type(H5Aget_type(box), H5Tclose);
        good = shape_of(space) == std::vector<hsize_t>{6} && is_number(type) && H5Aread(box, H5T_NATIVE_DOUBLE, numbers) >= 0;
    }
    if (!good) {
        faults.add(fmt::format("{}: has no attribute box of six numbers, xlo xhi ylo yhi zlo zhi in m", path));
        return;
    }
    for (int axis = 0; axis < 3; ++axis) {
        raw.bed.lo[axis] = numbers[2 * axis];
        raw.bed.hi[axis] = numbers[2 * axis + 1];
    }
    raw.has_box = true;
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
    read_box(file, path, raw, faults);
    Bed& bed = raw.bed;
    read_dataset(file, path, "id", 1, H5T_NATIVE_INT64, bed.label, faults);
    read_dataset(file, path, "position", 3, H5T_NATIVE_DOUBLE, bed.position, faults);
    read_dataset(file, path, "radius", 1, H5T_NATIVE_DOUBLE, bed.radius, faults);
    if (bed.position.size() != 3 * bed.label.size() || bed.radius.size() != bed.label.size()) {
        if (!bed.label.empty() && !bed.position.empty() && !bed.radius.empty())
            faults.add(fmt::format("{}: {} ids, {} positions and {} radii; there must be one of each a grain", path, bed.label.size(),
                                   bed.position.size() / 3, bed.radius.size()));
        bed = Bed{bed.lo, bed.hi, {}, {}, {}, {}};
    }
    return raw;
}

} // namespace talus::sandbox
