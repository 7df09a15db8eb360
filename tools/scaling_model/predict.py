"""Strong and weak scaling of a bed of sand: series of rank counts, replayed and compared with the first of each."""
import dataclasses

import numpy as np

from scaling_model.bed import Bed, Shares
from scaling_model.replay import LOSSES, losses, step_seconds

WEAK_GRAINS = 1.9e9 / 16384  # a rank


@dataclasses.dataclass
class Point:
    ranks: int
    shape: tuple
    grains: float      # a rank
    ghosts: float      # of the rank that has most, as the rest
    inner: float       # share of grains in tiles that see no ghosts; least
    messages: int
    megabytes: float
    seconds: float     # a step
    efficiency: float  # of the first of the series
    twice: float       # share of pairs that both sides evaluate
    losses: dict

    def as_json(self):
        return dataclasses.asdict(self)


@dataclasses.dataclass
class Series:
    name: str
    points: list


def point(bed, ranks, rule, costs, machine):
    shares = Shares(bed, bed.rank_grid(ranks, rule))
    return Point(ranks, shares.shape, float(np.mean(shares.grains)), float(np.max(shares.ghosts)), float(np.min(shares.inner)),
                 int(np.max(shares.messages())), 1e-6 * float(np.max(shares.bytes())), step_seconds(shares, costs, machine), 1.0,
                 float(np.max(shares.twice)), losses(shares, costs, machine))


def strong(bed, counts, rule, costs, machine):
    points = [point(bed, ranks, rule, costs, machine) for ranks in counts]
    first = points[0]
    for p in points:
        p.efficiency = first.seconds * first.ranks / (p.seconds * p.ranks)
    return Series(f"strong from {counts[0]} ranks, {bed.grains:.3g} grains", points)


def weak(bed, counts, rule, costs, machine):
    """The footprint grows with the ranks, the grains a rank, their size and the depth stay."""
    points = []
    for ranks in counts:
        area = ranks * WEAK_GRAINS / bed.grains
        grown = dataclasses.replace(bed, grains=ranks * WEAK_GRAINS, length=bed.length * area**0.5, width=bed.width * area**0.5)
        points.append(point(grown, ranks, rule, costs, machine))
    for p in points:
        p.efficiency = points[0].seconds / p.seconds
    return Series(f"weak, {WEAK_GRAINS:.3g} grains a rank", points)


def table(series):
    lines = [f"  {'ranks':>6} {'grid':>11} {'grains':>9} {'ghosts':>8} {'inner':>5} {'msgs':>4} {'MB':>6} {'ms/step':>9} {'eff':>6}"
             "  lost to, % of a step"]
    for s in series:
        lines.append(f"  {s.name}")
        for p in s.points:
            most_first = sorted(p.losses.items(), key=lambda item: -item[1])
            lost = ", ".join(f"{name} {100 * share:.1f}" for name, share in most_first if share >= 5e-4)
            grid = "x".join(map(str, p.shape))
            lines.append(f"  {p.ranks:>6} {grid:>11} {p.grains:>9.0f} {p.ghosts:>8.0f} {p.inner:>5.2f} {p.messages:>4} "
                         f"{p.megabytes:>6.2f} {1e3 * p.seconds:>9.3f} {p.efficiency:>6.3f}  {lost or '-'}")
    return "\n".join(lines)


def assumptions(bed, costs, machine):
    return "\n".join([
        f"Bed         {bed.grains:.3g} grains in {bed.length:g} x {bed.depth:g} x {bed.width:g} m (so d = {1e6 * bed.diameter():.0f} um);",
        f"            reach of lists {bed.reach() / bed.diameter():.2f} d",
        f"Costs       {costs.source}:",
        f"            force {1e9 * costs.force:.0f}, integrate {1e9 * costs.integrate:.0f} ns a grain and step; "
        f"ghosts packed and unpacked {1e9 * (costs.pack + costs.unpack):.0f} ns a ghost and step",
        f"            binning {1e9 * costs.binning:.0f}, pair build {1e9 * costs.pair_build:.0f} ns a grain and rebuild, "
        f"every {costs.steps_per_rebuild:.0f} steps; serial parts of a rebuild are estimates",
        f"Network     {1e6 * machine.latency:g} us, {1e-9 * machine.bandwidth:g} GB/s a rank; no congestion, no distance; "
        f"progress: {machine.progress}",
        f"Imbalance   max/mean {machine.imbalance:g} on any number of ranks; noise {machine.noise:g}; "
        f"cuts move every {machine.rebalance_steps:.0f} steps",
        "Threads     share a rank's tiles without loss but for the last tile; what many cores take from each other's memory bandwidth",
        "            is not modelled: it would make steps longer and efficiencies higher. One rank is one process.",
        "Losses      what a step gains when one thing is taken away and all else kept; they need not add up:",
        "            " + ", ".join(LOSSES),
    ])
