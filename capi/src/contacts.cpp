// Copies of contacts.
#include <functional>

#include "capi/src/guard.hpp"
#include "runtime/phase/observe.hpp"

using namespace talus;
using namespace talus::capi;

namespace {

/// What a field is made of: up to three numbers of a contact, as the type that the caller gets.
struct Field {
    std::size_t bytes;
    std::function<core::Vec3d(const core::ContactView&)> value; // of no concern for labels
    void (*put)(const runtime::ContactRow&, std::byte*);
};

template <class... T>
void put(std::byte* out, T... values) {
    ((std::memcpy(out, &values, sizeof values), out += sizeof values), ...);
}
void put_vector(const runtime::ContactRow& r, std::byte* out) { put(out, r.value.x, r.value.y, r.value.z); }

Field field_of(const runtime::EngineState& s, int32_t field) {
    using View = core::ContactView;
    switch (field) {
    case TALUS_CONTACT_LABELS: return {16, [](const View&) { return core::Vec3d{0, 0, 0}; }, [](const runtime::ContactRow& r, std::byte* out) { put(out, r.i, r.j); }};
    case TALUS_CONTACT_FORCE: return {24, [](const View& c) { return c.force; }, put_vector};
    case TALUS_CONTACT_NORMAL: return {24, [](const View& c) { return c.normal; }, put_vector};
    case TALUS_CONTACT_POINT: return {24, [&s](const View& c) { return runtime::contact_point(s, c); }, put_vector};
    case TALUS_CONTACT_OVERLAP: return {8, [](const View& c) { return core::Vec3d{c.overlap, 0, 0}; }, [](const runtime::ContactRow& r, std::byte* out) { put(out, r.value.x); }};
    case TALUS_CONTACT_SLIDING: return {4, [](const View& c) { return core::Vec3d{c.sliding ? 1.0 : 0.0, 0, 0}; }, [](const runtime::ContactRow& r, std::byte* out) { put(out, static_cast<int32_t>(r.value.x)); }};
    default: core::fail(core::ErrorKind::argument, "field {}: not one of TALUS_CONTACT_*", field);
    }
}

} // namespace

extern "C" {

talus_status talus_contacts_copy(talus_engine* engine, int32_t field, int64_t capacity, void* out_data, int64_t* out_count) {
    return with_engine(engine, [&](runtime::Engine& e) {
        runtime::EngineState& s = e.state();
        Field f;
        runtime::agree(*s.comm, [&] {
            f = field_of(s, field);
            require(out_count, "out_count");
            if (capacity < 0) core::fail(core::ErrorKind::argument, "capacity = {}: must be >= 0", capacity);
            if (capacity > 0) require(out_data, "out_data");
        });
        e.prepare_contacts();
        std::vector<runtime::ContactRow> rows;
        runtime::agree(*s.comm, [&] {
            rows = runtime::list_contacts(s, f.value);
            *out_count = static_cast<int64_t>(rows.size());
            if (capacity > 0 && capacity < *out_count) core::fail(core::ErrorKind::argument, "capacity {} is less than the {} contacts of rank {}", capacity, *out_count, s.comm->rank());
        });
        if (capacity == 0) return; // only asked how many
        auto* out = static_cast<std::byte*>(out_data);
        for (const runtime::ContactRow& r : rows) {
            f.put(r, out);
            out += f.bytes;
        }
    });
}

} // extern "C"
