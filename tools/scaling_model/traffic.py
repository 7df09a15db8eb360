"""What each rank sends in a step, exactly, from positions and cuts: the rule of runtime/comm/halo.cpp, written anew.

reach      2 r_max + skin: the farthest that the centres of a listed pair are apart
neighbour  a rank, or an image of one on a periodic axis that is cut, whose subdomain widened by the reach comes within another
           reach of mine
ghost      a grain of mine inside a neighbour's widened subdomain, once for each image
chunk      a tile of mine whose grains' box comes within a reach of the widened subdomain, once for each rank (not for each image):
           its displacements are sent even when none of its grains are, for the receiver must know how far it moved
message    one to each rank that gets a chunk; GHOST_BYTES a ghost and CHUNK_BYTES a chunk
An axis that is periodic but not cut has no images here: it wraps in the cells of its owner.
"""
import dataclasses
import itertools

import numpy as np

from scaling_model.subdomains import cells_of_rank

GHOST_BYTES = 12 * 8  # position, radius, velocity, mass, angular velocity, meta
CHUNK_BYTES = 12 * 8  # a box of displacements, and of those foreseen


@dataclasses.dataclass
class Traffic:
    """Of each rank: grains, tiles; messages, ghosts, chunks and bytes sent; ghosts taken."""
    particles: np.ndarray
    tiles: np.ndarray
    messages: np.ndarray
    sent: np.ndarray
    chunks: np.ndarray
    ghosts: np.ndarray

    def bytes(self):
        return GHOST_BYTES * self.sent + CHUNK_BYTES * self.chunks


def bounded(domain, boxes):
    """Subdomains with finite ends on periodic axes: beyond them lies an image, not more of the same rank."""
    boxes = boxes.copy()
    for a in np.flatnonzero(domain.periodic):
        boxes[:, 0, a] = np.where(np.isinf(boxes[:, 0, a]), domain.lo[a], boxes[:, 0, a])
        boxes[:, 1, a] = np.where(np.isinf(boxes[:, 1, a]), domain.hi[a], boxes[:, 1, a])
    return boxes


def near(lo, hi, shift, other_lo, other_hi, distance):
    """Whether boxes, shifted, are nearer to others than so much on every axis."""
    return np.all((lo + shift <= other_hi + distance) & (hi + shift >= other_lo - distance), axis=-1)


def tile_boxes(tile, positions):
    """Numbers and boxes of the tiles that hold grains."""
    order = np.argsort(tile, kind="stable")
    numbers, first = np.unique(tile[order], return_index=True)
    return numbers, np.minimum.reduceat(positions[order], first, axis=0), np.maximum.reduceat(positions[order], first, axis=0)


def halo_traffic(domain, grid, positions, reach, tile_grains=0):
    """@param grid SliceGrid  @param positions [n, 3] of all grains  @return Traffic"""
    ranks = grid.ranks
    out = Traffic(*(np.zeros(ranks, np.int64) for _ in range(6)))
    owner = grid.owners(positions)
    mine = bounded(domain, grid.boxes)
    wide = mine.copy()
    wraps = np.array([bool(domain.periodic[a]) and grid.shape[a] == 1 for a in range(3)])
    wide[:, 0, wraps], wide[:, 1, wraps] = -np.inf, np.inf
    wide[:, 0] -= reach
    wide[:, 1] += reach
    images = [(-1, 0, 1) if domain.periodic[a] and grid.shape[a] > 1 else (0,) for a in range(3)]
    lengths = np.array([domain.length(a) for a in range(3)])
    for rank in range(ranks):
        x = positions[owner == rank]
        cells = cells_of_rank(domain, grid, rank, x, reach, tile_grains)
        out.particles[rank], out.tiles[rank] = len(x), cells.n_tiles()
        if ranks == 1 or len(x) == 0:
            continue
        _, tile_lo, tile_hi = tile_boxes(cells.tile_of(x), x)
        interior = np.all(wraps | ((x - mine[rank, 0] > reach) & (mine[rank, 1] - x > reach)), axis=1)
        border = x[~interior]
        seen = {}  # neighbour rank: which tiles it sees
        for image in itertools.product(*images):
            shift = np.array(image) * lengths
            for other in np.flatnonzero(near(mine[rank, 0], mine[rank, 1], shift, wide[:, 0], wide[:, 1], reach)):
                if other == rank and image == (0, 0, 0):
                    continue
                tiles = near(tile_lo, tile_hi, shift, wide[other, 0], wide[other, 1], reach)
                if not np.any(tiles):
                    continue
                seen[other] = seen.get(other, False) | tiles
                ghosts = np.sum(np.all((border + shift >= wide[other, 0]) & (border + shift <= wide[other, 1]), axis=1))
                out.sent[rank] += ghosts
                out.ghosts[other] += ghosts
        out.messages[rank] = len(seen)
        out.chunks[rank] = sum(int(np.sum(tiles)) for tiles in seen.values())
    return out


def contacts_on_two_ranks(owner, pairs):
    """How many of these contacts (pairs of rows) have their grains on different ranks: both evaluate them."""
    return int(np.sum(owner[pairs[:, 0]] != owner[pairs[:, 1]]))
