#include "runtime/io/hdf5_memory.hpp"

#include <new>

namespace talus::runtime {

namespace {

/// Driver information in a file-access list.
struct Info {
    FileImage* image;
};

/// HDF5 sees the first member only.
struct OpenFile {
    H5FD_t base;
    FileImage* image;
    haddr_t allocated;
};

constexpr haddr_t kMaxAddress = (haddr_t{1} << 63) - 1;

OpenFile* own(H5FD_t* f) { return reinterpret_cast<OpenFile*>(f); }
const OpenFile* own(const H5FD_t* f) { return reinterpret_cast<const OpenFile*>(f); }

H5FD_t* open_image(const char*, unsigned flags, hid_t access_list, haddr_t) {
    const auto* info = static_cast<const Info*>(H5Pget_driver_info(access_list));
    if (info == nullptr) return nullptr;
    auto* f = new (std::nothrow) OpenFile{};
    if (f == nullptr) return nullptr;
    f->image = info->image;
    if ((flags & H5F_ACC_TRUNC) != 0) f->image->set_size(0);
    return &f->base;
}

herr_t close_image(H5FD_t* f) {
    delete own(f);
    return 0;
}

int compare(const H5FD_t* a, const H5FD_t* b) {
    const std::less<const FileImage*> less;
    return less(own(a)->image, own(b)->image) ? -1 : less(own(b)->image, own(a)->image) ? 1 : 0;
}

herr_t query(const H5FD_t*, unsigned long* flags) {
    if (flags != nullptr) *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
}

haddr_t allocated(const H5FD_t* f, H5FD_mem_t) { return own(f)->allocated; }
herr_t set_allocated(H5FD_t* f, H5FD_mem_t, haddr_t end) {
    own(f)->allocated = end;
    return 0;
}
haddr_t end_of_file(const H5FD_t* f, H5FD_mem_t) { return own(f)->image->size(); }

herr_t read_bytes(H5FD_t* f, H5FD_mem_t, hid_t, haddr_t at, size_t n, void* out) {
    own(f)->image->read(at, out, n);
    return 0;
}

herr_t write_bytes(H5FD_t* f, H5FD_mem_t, hid_t, haddr_t at, size_t n, const void* data) {
    try {
        own(f)->image->write(at, data, n);
        return 0;
    } catch (const std::bad_alloc&) {
        return -1;
    }
}

herr_t truncate(H5FD_t* f, hid_t, hbool_t) {
    own(f)->image->set_size(own(f)->allocated);
    return 0;
}

H5FD_class_t driver_class() {
    H5FD_class_t c{};
#if H5_VERSION_GE(1, 13, 2)
    c.version = H5FD_CLASS_VERSION;
    c.value = static_cast<H5FD_class_value_t>(512); // of the range for drivers that are not registered with the HDF Group
#endif
    c.name = "talus_image";
    c.maxaddr = kMaxAddress;
    c.fc_degree = H5F_CLOSE_STRONG;
    c.fapl_size = sizeof(Info);
    c.open = open_image;
    c.close = close_image;
    c.cmp = compare;
    c.query = query;
    c.get_eoa = allocated;
    c.set_eoa = set_allocated;
    c.get_eof = end_of_file;
    c.read = read_bytes;
    c.write = write_bytes;
    c.truncate = truncate;
    const H5FD_mem_t map[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
    std::copy(std::begin(map), std::end(map), c.fl_map);
    return c;
}

} // namespace

bool use_image(hid_t access_list, FileImage& image) {
    // Registered anew each time: HDF5 forgets drivers when MPI_Finalize shuts it down. The list and the file keep it alive.
    static const H5FD_class_t kClass = driver_class();
    const hid_t driver = H5FDregister(&kClass);
    if (driver < 0) return false;
    const Info info{&image};
    const bool set = H5Pset_driver(access_list, driver, &info) >= 0;
    H5FDunregister(driver);
    return set;
}

} // namespace talus::runtime
