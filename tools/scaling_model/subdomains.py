"""Who owns what: the slice grid of ranks, and the cells and tiles of a rank.

The rules are those of core/slice_grid.cpp, core/balance.cpp (cuts of equal cost), core/cells.cpp and runtime/phase/binning.cpp,
written anew for numpy. Cells and tiles are computed in the engine's own order of operations in double precision: a floor that
falls the other way would give another grid.
"""
import dataclasses
import math

import numpy as np

TILE_GRAINS = 1024  # kDefaultTileGrains
ORDER = (0, 2, 1)   # axes in the order in which they are cut


@dataclasses.dataclass
class Domain:
    lo: np.ndarray
    hi: np.ndarray
    periodic: np.ndarray  # bool

    def length(self, axis):
        return self.hi[axis] - self.lo[axis]


def choose_rank_grid(ranks, lengths, given=(0, 0, 0), periodic=(False, False, False)):
    """Ranks along x, y, z for which subdomains of the sand show others the least surface; axes given (> 0) are kept."""
    best, least = None, math.inf
    for x in range(1, ranks + 1):
        if ranks % x or (given[0] > 0 and given[0] != x):
            continue
        for y in range(1, ranks // x + 1):
            z = ranks // x // y
            if (ranks // x) % y or (given[1] > 0 and given[1] != y) or (given[2] > 0 and given[2] != z):
                continue
            parts = (x, y, z)
            sides = [length / n for length, n in zip(lengths, parts)]
            # A closed axis cut in two has one face a subdomain, else there are two.
            surface = sum(sides[b] * sides[c] * (0.5 if parts[a] == 2 and not periodic[a] else 1.0)
                          for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)) if parts[a] > 1)
            if surface < least:
                best, least = (x, y, z), surface
    if best is None:
        raise ValueError(f"a rank grid of {given} does not make {ranks} ranks")
    return best


class SliceGrid:
    """Slabs in x, each cut in z, each column of it in y. Rank (ix nz + iz) ny + iy; outer ends are infinite."""

    def __init__(self, boxes, shape):
        self.boxes = boxes  # [ranks][lo, hi][axis]
        self.shape = tuple(shape)
        self.ranks = len(boxes)

    @classmethod
    def from_run(cls, lo, hi, domain):
        """From subdomains as a run tells them: outer ends are the domain's, and so tell which come first along an axis."""
        boxes = np.stack([lo, hi], axis=1).astype(float)
        ranks = len(boxes)
        first = lo == domain.lo
        # All of the first slab begin where the domain does in x, and all of its first column in z too.
        slab, column = int(np.sum(first[:, 0])), int(np.sum(first[:, 0] & first[:, 2]))
        shape = (ranks // max(slab, 1), column, slab // max(column, 1))
        if shape[0] * shape[1] * shape[2] != ranks:
            raise ValueError(f"{ranks} subdomains do not make a slice grid")
        boxes[:, 0][first] = -np.inf
        boxes[:, 1][hi == domain.hi] = np.inf
        return cls(boxes, shape)

    @classmethod
    def equal_counts(cls, positions, shape):
        """Cuts that give every rank as many grains: what the engine's balance comes to when all grains cost the same."""
        boxes = np.empty((shape[0] * shape[1] * shape[2], 2, 3))
        boxes[:, 0], boxes[:, 1] = -np.inf, np.inf
        rank = np.arange(len(boxes))
        index = (rank // (shape[1] * shape[2]), rank % shape[1], rank // shape[1] % shape[2])

        def divide(rows, ranks, depth):
            if depth == 3:
                return
            axis = ORDER[depth]
            parts, x = shape[axis], np.sort(positions[rows, axis])
            middle = [len(x) * k // parts for k in range(1, parts)]
            ends = [-np.inf] + [0.5 * (x[m - 1] + x[m]) for m in middle] + [np.inf]
            for k in range(parts):
                mine = ranks[index[axis][ranks] == k]
                boxes[mine, 0, axis], boxes[mine, 1, axis] = ends[k], ends[k + 1]
                divide(rows[(positions[rows, axis] >= ends[k]) & (positions[rows, axis] < ends[k + 1])], mine, depth + 1)

        divide(np.arange(len(positions)), rank, 0)
        return cls(boxes, shape)

    def owners(self, positions):
        owner = np.full(len(positions), -1)
        for rank, (lo, hi) in enumerate(self.boxes):
            owner[np.all((positions >= lo) & (positions < hi), axis=1)] = rank
        if np.any(owner < 0):
            raise ValueError("a grain lies in no subdomain: cuts and grains are not of the same run")
        return owner


@dataclasses.dataclass
class CellGrid:
    origin: np.ndarray
    inverse_width: np.ndarray
    cells: np.ndarray
    tiles: np.ndarray

    def n_tiles(self):
        return int(np.prod(self.tiles))

    def tile_begin(self, axis, tile):
        return tile * int(self.cells[axis]) // int(self.tiles[axis])

    def tile_of(self, positions):
        place = []
        for axis in range(3):
            along = (positions[:, axis] - self.origin[axis]) * self.inverse_width[axis]
            cell = np.clip(along, 0.0, float(self.cells[axis] - 1)).astype(np.int64)
            place.append(((cell + 1) * int(self.tiles[axis]) - 1) // int(self.cells[axis]))
        return (place[0] * self.tiles[1] + place[1]) * self.tiles[2] + place[2]


def choose_cells(domain, lo, hi, reach, wraps, grains, tile_grains=TILE_GRAINS):
    """Cells at least as wide as the reach, and tiles of about so many grains, of a rank whose grains and ghosts lie in lo to hi."""
    extent = [domain.length(a) if wraps[a] else max(hi[a] - lo[a], 0.0) for a in range(3)]
    width = reach
    while True:
        product = 1.0
        for e in extent:
            product *= max(1.0, math.floor(e / width))
        if product <= 4.0 * grains + 64.0:
            break
        width *= 1.25
    cells, inverse = [], []
    for e in extent:
        n = max(1, int(math.floor(e / width)))
        if e > 0.0 and e / n < reach and n > 1:
            n -= 1
        cells.append(n)
        inverse.append(n / e if e > 0.0 else 1.0 / width)
    tiles = [1, 1, 1]
    while grains / (tiles[0] * tiles[1] * tiles[2]) > max(tile_grains, 1):
        longest = -1
        for a in range(3):
            if cells[a] // (tiles[a] + 1) < 2:
                continue
            if longest < 0 or cells[a] * tiles[longest] > cells[longest] * tiles[a]:
                longest = a
        if longest < 0:
            break
        tiles[longest] += 1
    origin = [domain.lo[a] if wraps[a] else lo[a] for a in range(3)]
    return CellGrid(np.array(origin), np.array(inverse), np.array(cells), np.array(tiles))


def cells_of_rank(domain, grid, rank, positions, reach, tile_grains=0):
    """The grid of a rank that owns these positions: their box, with room for ghosts where the subdomain is cut."""
    wraps = [bool(domain.periodic[a]) and grid.shape[a] == 1 for a in range(3)]
    if len(positions):
        lo, hi = positions.min(axis=0), positions.max(axis=0)
    else:
        lo, hi = np.array(domain.lo, float), np.array(domain.lo, float)
    for a in range(3):
        image = domain.periodic[a] and not wraps[a]
        if np.isfinite(grid.boxes[rank, 0, a]) or image:
            lo[a] -= reach
        if np.isfinite(grid.boxes[rank, 1, a]) or image:
            hi[a] += reach
    return choose_cells(domain, lo, hi, reach, wraps, len(positions), tile_grains if tile_grains > 0 else TILE_GRAINS)
