"""A bed of sand shared out evenly: how much each rank holds, sees and sends, from geometry alone.

A rank owns a box a x b x c of sand of n grains a volume. Its sides that face another rank have area S in all; the bed's own
faces have no neighbour. With the reach r = d_max + skin (farthest centres of a listed pair):
  ghosts       n (volume of the box widened by r at those sides - volume of the box)
  pairs twice  a contact is d long and of any direction, so n z d / 2 of them cross a unit of area (n z contacts a volume, and
               |cos| is 1/2 in the mean). They are evaluated on both sides; on one rank each counts half. So the force takes
                   1 + g times as long,   g = d S / (4 a b c)
               whatever z is; `scaling-model traffic` compares this with contacts counted in a run. Integrate does not grow.
  tiles        by the engine's own rule; those of the outermost layer at a cut side see ghosts and wait for them, and the
               next layer integrates after them
  messages     to the 8 (two axes cut) or 26 (three) ranks around; ghosts of edges and corners are those of the widened box there
"""
import copy
import dataclasses
import itertools
import math

import numpy as np

from scaling_model.subdomains import Domain, choose_cells, choose_rank_grid
from scaling_model.traffic import CHUNK_BYTES, GHOST_BYTES

SOLID = 0.60          # share of the volume that grains fill
LARGEST = 250.0 / 227.5  # largest grain, in means: uniform within 22.5 um of 227.5 um


@dataclasses.dataclass
class Bed:
    """A bed of sand in its domain. Lengths in m; y is up."""
    grains: float
    length: float
    depth: float
    width: float
    skin: float = 0.1    # of the largest diameter
    periodic_z: bool = False

    def diameter(self):
        return (SOLID * self.length * self.depth * self.width / self.grains * 6.0 / math.pi) ** (1.0 / 3.0)

    def reach(self):
        return (1.0 + self.skin) * LARGEST * self.diameter()

    def rank_grid(self, ranks, rule):
        """By the engine's rule, or as given."""
        return choose_rank_grid(ranks, (self.length, self.depth, self.width), (0, 0, 0) if rule == "engine" else rule,
                                (False, False, self.periodic_z))


class Shares:
    """Arrays of shape (nx, ny, nz): what each rank holds and sees. `send` maps each direction to [ghosts, chunks] arrays."""

    def __init__(self, bed, shape):
        self.shape = shape
        self.periodic = (False, False, bed.periodic_z and shape[2] > 1)
        reach, sizes = bed.reach(), (bed.length / shape[0], bed.depth / shape[1], bed.width / shape[2])
        if any(n > 1 and size < reach for n, size in zip(shape, sizes)):
            raise ValueError(f"subdomains of a grid {shape} would be narrower than the reach")
        density = bed.grains / (bed.length * bed.depth * bed.width)
        volume = sizes[0] * sizes[1] * sizes[2]
        self.grains = np.full(shape, density * volume)
        # Whether there is a neighbour below and above, along each axis.
        self.sides = []
        for a, n in enumerate(shape):
            k = np.arange(n)
            has = np.stack([(k > 0) | self.periodic[a], (k < n - 1) | self.periodic[a]]) & (n > 1)
            self.sides.append([np.broadcast_to(h.reshape([-1 if b == a else 1 for b in range(3)]), shape) for h in has])
        count = [low.astype(int) + high for low, high in self.sides]
        widened = 1.0
        for a in range(3):
            widened = widened * (sizes[a] + reach * count[a])
        self.ghosts = density * (widened - volume)
        area = sum(count[a] * volume / sizes[a] for a in range(3))
        self.twice = bed.diameter() * area / (4.0 * volume)
        self.tiles, self.inner, self.early = np.empty(shape), np.empty(shape), np.empty(shape)
        depth_of = [{} for _ in range(3)]
        # Ranks with as many sides are alike: at most 27 kinds.
        for kind in itertools.product(range(3), repeat=3):
            rows = (count[0] == kind[0]) & (count[1] == kind[1]) & (count[2] == kind[2])
            if not np.any(rows):
                continue
            domain = Domain(np.zeros(3), np.array([bed.length, bed.depth, bed.width]), np.array([False, False, bed.periodic_z]))
            wraps = [False, False, bed.periodic_z and shape[2] == 1]
            extent = [sizes[a] + reach * kind[a] for a in range(3)]
            cells = choose_cells(domain, [0.0] * 3, extent, reach, wraps, density * volume)
            inner = early = 1.0
            for a in range(3):
                inner *= own_share(cells, a, kind[a], 1, sizes[a], reach)
                early *= own_share(cells, a, kind[a], 2, sizes[a], reach)
                depth_of[a][kind] = (int(cells.tiles[a]), math.ceil(2 * reach / (extent[a] / cells.tiles[a])))
            self.tiles[rows], self.inner[rows], self.early[rows] = cells.n_tiles(), inner, early
        self.send = {}
        for way in itertools.product((-1, 0, 1), repeat=3):
            if way == (0, 0, 0) or any(w and shape[a] == 1 for a, w in enumerate(way)):
                continue
            there, volume_seen = np.ones(shape, bool), 1.0
            for a, w in enumerate(way):
                if w:
                    there = there & self.sides[a][(w + 1) // 2]
                volume_seen *= reach if w else sizes[a]
            chunks = np.zeros(shape)
            for kind in itertools.product(range(3), repeat=3):
                rows = (count[0] == kind[0]) & (count[1] == kind[1]) & (count[2] == kind[2])
                if np.any(rows):
                    chunks[rows] = np.prod([min(depth_of[a][kind]) if w else depth_of[a][kind][0] for a, w in enumerate(way)])
            self.send[way] = (there * density * volume_seen, there * chunks, there)

    def once(self):
        """The same, as if a pair across a cut were evaluated on one side only."""
        other = copy.copy(self)
        other.twice = np.zeros(self.shape)
        return other

    def ranks(self):
        return self.shape[0] * self.shape[1] * self.shape[2]

    def messages(self):
        return sum((there.astype(int) for _, _, there in self.send.values()), np.zeros(self.shape, int))

    def bytes(self):
        return sum((GHOST_BYTES * g + CHUNK_BYTES * c for g, c, _ in self.send.values()), np.zeros(self.shape))


def own_share(cells, axis, sides, layers, size, reach):
    """The share of a rank's own length that lies behind so many layers of tiles at each side with a neighbour."""
    n, width = int(cells.tiles[axis]), (size + sides * reach) / int(cells.cells[axis])
    if sides == 0:
        return 1.0
    if n <= layers * sides:
        return 0.0
    last = n - layers if sides == 2 else n
    return min(1.0, (cells.tile_begin(axis, last) - cells.tile_begin(axis, layers)) * width / size)
