// runtime/io/checkpoint_layout.hpp: names and shapes of a checkpoint's bulk data, for writing and reading.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <span>
#include <type_traits>

#include "runtime/io/columns.hpp"

namespace talus::runtime {

static_assert(std::endian::native == std::endian::little, "files are little-endian, and meta is taken apart by its bytes");

/// Where the rows of /grains live in memory: sums in a list, or without one in the tiles.
struct GrainRows {
    core::Particle* particles;
    core::Reference* references;
    core::ForceSum* sums;
    std::span<core::Tile> tiles = {};

    core::ForceSum& sum(std::uint64_t i) const {
        if (sums != nullptr) return sums[i];
        core::Tile& tile = *(std::upper_bound(tiles.begin(), tiles.end(), i, [](std::uint64_t v, const core::Tile& t) { return v < t.first; }) - 1);
        return tile.sums[i - tile.first];
    }
};

struct GrainColumn {
    const char* name;
    const char* unit;
    Kind kind;
    std::uint64_t width; // 0: a plain list
    void* (*at)(const GrainRows& g, std::uint64_t i);
};

/// Byte `k` of meta.
template <int k>
void* meta_byte(const GrainRows& g, std::uint64_t i) {
    return reinterpret_cast<std::byte*>(&g.particles[i].meta) + k;
}

inline constexpr std::array<GrainColumn, 12> kGrainColumns{{
    {"label", "", Kind::i64, 0, [](const GrainRows& g, std::uint64_t i) -> void* { return &g.particles[i].label; }},
    {"position", "m", Kind::f64, 3, [](const GrainRows& g, std::uint64_t i) -> void* { return g.particles[i].position; }},
    {"velocity", "m/s", Kind::f64, 3, [](const GrainRows& g, std::uint64_t i) -> void* { return g.particles[i].velocity; }},
    {"angular_velocity", "rad/s", Kind::f64, 3, [](const GrainRows& g, std::uint64_t i) -> void* { return g.particles[i].angular_velocity; }},
    {"radius", "m", Kind::f64, 0, [](const GrainRows& g, std::uint64_t i) -> void* { return &g.particles[i].radius; }},
    {"mass", "kg", Kind::f64, 0, [](const GrainRows& g, std::uint64_t i) -> void* { return &g.particles[i].mass; }},
    {"material", "", Kind::u8, 0, meta_byte<0>},
    {"group", "", Kind::u8, 0, meta_byte<1>},
    {"colour", "", Kind::u8, 0, meta_byte<2>},
    {"force", "units/force", Kind::i64, 3, [](const GrainRows& g, std::uint64_t i) -> void* { return g.sum(i).force; }},
    {"torque", "units/torque", Kind::i64, 3, [](const GrainRows& g, std::uint64_t i) -> void* { return g.sum(i).torque; }},
    {"reference", "m", Kind::f64, 3, [](const GrainRows& g, std::uint64_t i) -> void* { return g.references[i].data(); }},
}};

inline constexpr const char* kGrains = "/grains/";
inline constexpr const char* kContactNumber = "/contacts/number";
inline constexpr const char* kContactPartner = "/contacts/partner";
inline constexpr const char* kContactHistory = "/contacts/history"; // absent when the laws keep no history
inline constexpr const char* kState = "/state/";
inline constexpr const char* kFormatName = "Talus checkpoint";

/// The columns of /grains. @param writing  from memory to bytes, else back
inline std::vector<Column> grain_columns(const GrainRows& grains, const Rows& rows, bool writing) {
    std::vector<Column> columns;
    for (const GrainColumn& g : kGrainColumns) {
        // The length of a row as a constant: its copy is then a move or two.
        const auto mover = [&](auto bytes) {
            return [grains, at = g.at, bytes, writing](std::uint64_t row, std::uint64_t n, std::byte* buffer) {
                for (std::uint64_t k = 0; k < n; ++k) {
                    void* const there = at(grains, row + k);
                    std::byte* const here = buffer + k * bytes;
                    writing ? std::memcpy(here, there, bytes) : std::memcpy(there, here, bytes);
                }
            };
        };
        const std::size_t bytes = size_of(g.kind) * (g.width == 0 ? 1 : g.width);
        TALUS_CHECK(bytes == 1 || bytes == 8 || bytes == 24);
        std::function<void(std::uint64_t, std::uint64_t, std::byte*)> move;
        if (bytes == 1) move = mover(std::integral_constant<std::size_t, 1>{});
        if (bytes == 8) move = mover(std::integral_constant<std::size_t, 8>{});
        if (bytes == 24) move = mover(std::integral_constant<std::size_t, 24>{});
        columns.push_back({std::string(kGrains) + g.name, g.unit, g.kind, g.width, rows, move});
    }
    return columns;
}

/// A column whose memory is one row after the other.
inline Column plain_column(const char* name, Kind kind, std::uint64_t width, const Rows& rows, void* memory, bool writing) {
    const std::size_t bytes = size_of(kind) * (width == 0 ? 1 : width);
    const auto move = [=](std::uint64_t row, std::uint64_t n, std::byte* buffer) {
        std::byte* const there = static_cast<std::byte*>(memory) + row * bytes;
        writing ? std::memcpy(buffer, there, n * bytes) : std::memcpy(there, buffer, n * bytes);
    };
    return {name, "", kind, width, rows, move};
}

} // namespace talus::runtime
