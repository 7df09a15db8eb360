#include "core/cells.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace talus::core {

CellOrder::CellOrder(const CellGrid& g) : grid(g) {
    first_of_tile.assign(static_cast<std::size_t>(g.n_tiles()) + 1, 0);
    for (int x = 0, t = 0; x < g.tiles[0]; ++x)
        for (int y = 0; y < g.tiles[1]; ++y)
            for (int z = 0; z < g.tiles[2]; ++z, ++t) {
                std::uint32_t n = 1;
                const int at[3] = {x, y, z};
                for (int a = 0; a < 3; ++a) n *= static_cast<std::uint32_t>(g.tile_begin(a, at[a] + 1) - g.tile_begin(a, at[a]));
                first_of_tile[t + 1] = first_of_tile[t] + n;
            }
}

CellGrid choose_grid(const Domain& domain, const double (&lo)[3], const double (&hi)[3], double reach, const bool (&wraps)[3],
                     std::size_t n_grains, std::size_t tile_grains) {
    CellGrid g;
    // Cells far more numerous than grains (a few stray grains in a wide box) would only cost memory: widen them.
    const double most_cells = 4.0 * static_cast<double>(n_grains) + 64.0;
    double width = reach;
    for (;; width *= 1.25) {
        double product = 1.0;
        for (int a = 0; a < 3; ++a) {
            const double extent = wraps[a] ? domain.length(a) : std::max(hi[a] - lo[a], 0.0);
            product *= std::max(1.0, std::floor(extent / width));
        }
        if (product <= most_cells) break;
    }
    for (int a = 0; a < 3; ++a) {
        g.wraps[a] = wraps[a];
        const double extent = wraps[a] ? domain.length(a) : std::max(hi[a] - lo[a], 0.0);
        g.cells[a] = std::max(1, static_cast<int>(std::floor(extent / width)));
        g.origin[a] = wraps[a] ? domain.lo[a] : lo[a];
        g.period[a] = wraps[a] ? domain.length(a) : 0.0;
        g.inverse_width[a] = extent > 0.0 ? g.cells[a] / extent : 1.0 / width;
        // extent/cells >= width >= reach up to rounding of the quotient; keep the guarantee.
        if (extent > 0.0 && extent / g.cells[a] < reach && g.cells[a] > 1) {
            --g.cells[a];
            g.inverse_width[a] = g.cells[a] / extent;
        }
    }
    // Split the longest side of the bricks until a tile holds about tile_grains.
    const double aim = static_cast<double>(std::max<std::size_t>(tile_grains, 1));
    for (;;) {
        if (static_cast<double>(n_grains) / g.n_tiles() <= aim) break;
        int longest = -1;
        for (int a = 0; a < 3; ++a) {
            if (g.cells[a] / (g.tiles[a] + 1) < 2) continue; // at least two cells across
            if (longest < 0 || g.cells[a] * g.tiles[longest] > g.cells[longest] * g.tiles[a]) longest = a;
        }
        if (longest < 0) break;
        ++g.tiles[longest];
    }
    return g;
}

} // namespace talus::core
