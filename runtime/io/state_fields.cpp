#include "runtime/io/state_fields.hpp"

#include <bit>
#include <limits>

#include "core/error.hpp"

namespace talus::runtime {

using core::ErrorKind;
using core::fail;

namespace {

using Words = std::vector<std::uint64_t>;

/// Walks over the scalars of a field three ways: what they are, out of them, into them.
class Fields {
public:
    explicit Fields(const FieldSink& sink) : sink_(&sink) {}
    explicit Fields(const FieldSource& source) : source_(&source) {}

    template <class T>
    void value(const char* name, const char* unit, T& x) {
        field(name, unit, {}, [&](auto&& cell) { cell(x); });
    }
    template <class T, std::size_t N>
    void vector(const char* name, const char* unit, T (&x)[N]) {
        field(name, unit, {N}, [&](auto&& cell) {
            for (T& one : x) cell(one);
        });
    }
    /// A row an item; visit(item, cell) gives each scalar of it to `cell`.
    template <class Items, class Visit>
    void column(const char* name, const char* unit, Items& items, Visit visit) {
        field(name, unit, {std::size(items)}, [&](auto&& cell) {
            for (auto& item : items) visit(item, cell);
        });
    }
    /// A square table over materials.
    template <class T, class Visit>
    void table(const char* name, const char* unit, T (&items)[core::kMaxMaterials][core::kMaxMaterials], std::uint64_t n, Visit visit) {
        field(name, unit, {n, n}, [&](auto&& cell) {
            for (std::uint64_t a = 0; a < n; ++a)
                for (std::uint64_t b = 0; b < n; ++b) visit(items[a][b], cell);
        });
    }
    /// The number of items of a vector, which is given that size when reading.
    template <class T>
    void count(const char* name, std::vector<T>& items, int most) {
        auto n = static_cast<std::int64_t>(items.size());
        value(name, "", n);
        if (n < 0 || n > most) fail(ErrorKind::io, "{} = {} is not in 0..{}", name, n, most);
        items.resize(static_cast<std::size_t>(n));
    }

private:
    template <class T>
    static constexpr Kind kind_of_cell() {
        if constexpr (std::is_same_v<T, double>) return Kind::f64;
        else if constexpr (std::is_same_v<T, std::uint64_t>) return Kind::u64;
        else return Kind::i64;
    }
    template <class T>
    static void to_words(const T& x, Words& out) {
        if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::uint64_t>) {
            out.push_back(std::bit_cast<std::uint64_t>(x));
        } else if constexpr (std::is_same_v<T, core::Wide>) {
            out.push_back(static_cast<std::uint64_t>(x));
            out.push_back(static_cast<std::uint64_t>(x >> 64));
        } else {
            out.push_back(static_cast<std::uint64_t>(static_cast<std::int64_t>(x)));
        }
    }
    template <class T>
    static void from_words(const std::uint64_t*& in, T& x, const char* name) {
        if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::uint64_t>) {
            x = std::bit_cast<T>(*in++);
        } else if constexpr (std::is_same_v<T, core::Wide>) {
            const std::uint64_t lo = *in++;
            x = static_cast<core::Wide>(static_cast<unsigned __int128>(*in++) << 64 | lo);
        } else {
            const auto v = static_cast<std::int64_t>(*in++);
            constexpr bool kFlag = std::is_same_v<T, bool>, kWhole = std::is_same_v<T, std::int64_t>;
            if (!kWhole && (v < (kFlag ? 0 : std::numeric_limits<std::int32_t>::min()) || v > (kFlag ? 1 : std::numeric_limits<std::int32_t>::max())))
                fail(ErrorKind::io, "{} = {} is out of range", name, v);
            x = static_cast<T>(v);
        }
    }

    /// @param shape  leading extents; values beyond their product add a last one
    template <class Visit>
    void field(const char* name, const char* unit, Shape shape, Visit visit) {
        Words words;
        Kind kind = Kind::i64;
        visit([&](auto& x) {
            kind = kind_of_cell<std::remove_cvref_t<decltype(x)>>();
            to_words(x, words);
        });
        if (words.empty()) return; // a table without rows
        if (const std::uint64_t width = words.size() / items_of(shape); width > 1) shape.push_back(width);
        if (sink_ != nullptr) {
            (*sink_)(name, unit, kind, shape, words.data());
            return;
        }
        (*source_)(name, kind, shape, words.data());
        const std::uint64_t* in = words.data();
        visit([&](auto& x) { from_words(in, x, name); });
    }

    const FieldSink* sink_ = nullptr;
    const FieldSource* source_ = nullptr;
};

constexpr auto kVec3 = [](core::Vec3d& v, auto&& cell) {
    cell(v.x);
    cell(v.y);
    cell(v.z);
};

constexpr auto kTriple = [](auto& items, auto&& cell) {
    for (auto& one : items) cell(one);
};

void each_setting(Fields& f, Settings& s) {
    f.vector("domain/lo", "m", s.domain.lo);
    f.vector("domain/hi", "m", s.domain.hi);
    f.vector("domain/periodic", "", s.domain.periodic);
    f.vector("gravity", "m/s^2", s.gravity);
    f.value("time_step", "s", s.time_step);
    f.value("time_step_limit", "of the Rayleigh step", s.time_step_limit);
    f.value("radius_max_declared", "m", s.radius_max);
    f.value("energy_ledger", "", s.energy_ledger);
    f.value("seed", "", s.seed);
    core::Laws& l = s.laws;
    f.value("laws/normal", "", l.normal);
    f.value("laws/damping", "", l.damping);
    f.value("laws/tangential", "", l.tangential);
    f.value("laws/rolling", "", l.rolling);
    f.value("laws/rolling_radius", "", l.rolling_radius);
    f.value("laws/tangential_damping", "", l.tangential_damping);
    f.value("laws/rolling_rate", "rad/s", l.rolling_rate);
    f.value("laws/rolling_damping", "", l.rolling_damping);
    f.value("laws/stiffness_n", "N/m", l.stiffness_n);
    f.value("laws/stiffness_t", "N/m", l.stiffness_t);
}

void each_material(Fields& f, Model& m, PairTable& pairs) {
    using core::ContactMaterial;
    using core::Material;
    using core::PairParameters;
    f.count("materials/number", m.materials, core::kMaxMaterials);
    const std::uint64_t n = m.materials.size();
    f.column("materials/young", "Pa", m.materials, [](Material& x, auto&& cell) { cell(x.young); });
    f.column("materials/poisson", "", m.materials, [](Material& x, auto&& cell) { cell(x.poisson); });
    f.column("materials/density", "kg/m^3", m.materials, [](Material& x, auto&& cell) { cell(x.density); });
    f.column("materials/rigid", "", m.materials, [](Material& x, auto&& cell) { cell(x.rigid); });
    f.table("contacts/restitution", "", m.contacts, n, [](ContactMaterial& x, auto&& cell) { cell(x.restitution); });
    f.table("contacts/friction", "", m.contacts, n, [](ContactMaterial& x, auto&& cell) { cell(x.friction); });
    f.table("contacts/rolling_friction", "", m.contacts, n, [](ContactMaterial& x, auto&& cell) { cell(x.rolling_friction); });
    f.table("contacts/is_set", "", m.contacts, n, [](ContactMaterial& x, auto&& cell) { cell(x.is_set); });
    // Derived, and yet stored: log and exp differ between processors.
    f.table("contacts/derived", "see PairParameters in core/material.hpp", pairs, n, [](PairParameters& x, auto&& cell) {
        for (double* v : {&x.stiffness_n, &x.stiffness_t, &x.damping_n, &x.damping_t, &x.friction, &x.rolling_friction, &x.rolling_damping, &x.pad}) cell(*v);
    });
}

void each_wall(Fields& f, Model& m, Totals& t) {
    f.count("walls/number", m.walls, core::kMaxWalls);
    t.wall_last.resize(m.walls.size());
    t.wall_impulse.resize(3 * m.walls.size());
    f.column("walls/point", "m", m.walls, [](Wall& w, auto&& cell) { kVec3(w.plane.point, cell); });
    f.column("walls/normal", "", m.walls, [](Wall& w, auto&& cell) { kVec3(w.plane.normal, cell); });
    f.column("walls/velocity", "m/s", m.walls, [](Wall& w, auto&& cell) { kVec3(w.plane.velocity, cell); });
    f.column("walls/material", "", m.walls, [](Wall& w, auto&& cell) { cell(w.plane.material); });
    f.column("walls/work", "J", m.walls, [](Wall& w, auto&& cell) { cell(w.work); });
    f.column("walls/force", "units/force, 128 bits as low and high halves", t.wall_last, [](core::WallSum& w, auto&& cell) { kTriple(w.force, cell); });
    f.column("walls/torque", "units/wall_torque, 128 bits as low and high halves", t.wall_last, [](core::WallSum& w, auto&& cell) { kTriple(w.torque, cell); });
    f.column("walls/touching", "", t.wall_last, [](core::WallSum& w, auto&& cell) { cell(w.contacts); });
    f.column("walls/impulse", "units/force times steps, 128 bits as low and high halves", t.wall_impulse, [](core::Wide& w, auto&& cell) { cell(w); });
}

void each_field(Fields& f, Model& m, PairTable& pairs, Totals& t) {
    const auto unit = [&](const char* name, const char* of, core::FixedUnit& u) {
        f.value(name, of, u.unit);
        u.scale = 1.0 / u.unit; // exact: a power of two
    };
    f.value("step", "", m.step);
    f.value("time", "s", m.time);
    f.value("particles", "", m.n_particles);
    f.value("radius_max", "m", m.radius_max);
    f.value("radius_min", "m", m.radius_min);
    each_setting(f, m.settings);
    each_material(f, m, pairs);
    f.value("units/are_fixed", "", m.units_fixed);
    unit("units/force", "N", m.units.force);
    unit("units/torque", "N m", m.units.torque);
    unit("units/wall_torque", "N m", m.units.wall_torque);
    each_wall(f, m, t);
    f.column("groups/mode", "", m.groups, [](core::GroupMotion& g, auto&& cell) { cell(g.mode); });
    f.column("groups/velocity", "m/s", m.groups, [](core::GroupMotion& g, auto&& cell) { kTriple(g.velocity, cell); });
    f.column("groups/angular_velocity", "rad/s", m.groups, [](core::GroupMotion& g, auto&& cell) { kTriple(g.angular_velocity, cell); });
    f.value("heat/friction", "units/torque, 128 bits as low and high halves", t.heat.friction);
    f.value("heat/damping", "units/torque, 128 bits as low and high halves", t.heat.damping);
    f.value("heat/rolling", "units/torque, 128 bits as low and high halves", t.heat.rolling);
}

} // namespace

void put_fields(const Model& model, const PairTable& pairs, const Totals& totals, const FieldSink& sink) {
    // The walk is the one for reading, on copies.
    Model m = model;
    Totals t = totals;
    PairTable p;
    std::copy(&pairs[0][0], &pairs[0][0] + core::kMaxMaterials * core::kMaxMaterials, &p[0][0]);
    Fields fields(sink);
    each_field(fields, m, p, t);
}

void take_fields(const FieldSource& source, Model& model, PairTable& pairs, Totals& totals) {
    Fields fields(source);
    each_field(fields, model, pairs, totals);
}

} // namespace talus::runtime
