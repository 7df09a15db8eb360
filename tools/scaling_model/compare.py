"""The model beside runs: traffic, which must be equal, and times, which should be near."""
import dataclasses

import numpy as np

from scaling_model.bed import Bed, Shares
from scaling_model.costs import costs_of_run
from scaling_model.replay import step_seconds
from scaling_model.subdomains import SliceGrid, choose_rank_grid
from scaling_model.traffic import contacts_on_two_ranks, halo_traffic

COLUMNS = ("particles", "ghosts", "tiles", "halo_messages", "halo_bytes")


def model_columns(traffic):
    return dict(zip(COLUMNS, (traffic.particles, traffic.ghosts, traffic.tiles, traffic.messages, traffic.bytes())))


def exact(run, every_rank=False):
    """@return (lines of a table, whether every rank's numbers are equal)"""
    traffic = halo_traffic(run.domain, run.grid, run.positions, run.reach, run.tile_grains)
    model = model_columns(traffic)
    grid = "x".join(map(str, run.grid.shape))
    lines, equal = [], True
    for name in COLUMNS:
        there = run.column(name)
        same = np.array_equal(model[name], there)
        equal = equal and same
        off = "" if same else f", first at rank {int(np.flatnonzero(model[name] != there)[0])}"
        lines.append(f"  {run.ranks:>5} {grid:>8}  {name:<14} {int(np.sum(model[name])):>12} {int(np.sum(there)):>12}  "
                     + ("equal on every rank" if same else "DIFFERS" + off))
        if every_rank:
            lines += [f"  {rank:>14}  {name:<14} {int(model[name][rank]):>12} {int(there[rank]):>12}" for rank in range(run.ranks)]
    return lines, equal


def doubled_contacts(run, grid):
    """The share of contacts that two ranks evaluate: counted, and d S / (4 V) of all areas between subdomains (bed.py)."""
    pairs = run.contact_pairs()
    counted = contacts_on_two_ranks(grid.owners(run.positions), pairs) / max(len(pairs), 1)
    # The sand ends at its outer grains, half a diameter beyond their centres.
    lo, hi = run.positions.min(axis=0) - 0.5 * run.mean_diameter, run.positions.max(axis=0) + 0.5 * run.mean_diameter
    lo, hi = np.where(run.domain.periodic, run.domain.lo, lo), np.where(run.domain.periodic, run.domain.hi, hi)
    sizes = np.clip(grid.boxes[:, 1], lo, hi) - np.clip(grid.boxes[:, 0], lo, hi)
    area = 0.0
    for a in range(3):
        images = run.domain.periodic[a] and grid.shape[a] > 1
        sides = 2 * np.ones(grid.ranks) if images else np.sum(np.isfinite(grid.boxes[:, :, a]), axis=1)
        area += np.sum(sides * np.prod(np.delete(sizes, a, axis=1), axis=1))
    return counted, run.mean_diameter * area / (4.0 * np.prod(hi - lo))


def foreign(run, ranks, given):
    """The same grains on other ranks, cut so that each has as many."""
    extent = run.positions.max(axis=0) - run.positions.min(axis=0)
    lengths = [run.domain.length(a) if run.domain.periodic[a] else extent[a] for a in range(3)]
    shape = choose_rank_grid(ranks, lengths, given, run.domain.periodic)
    grid = SliceGrid.equal_counts(run.positions, shape)
    return grid, halo_traffic(run.domain, grid, run.positions, run.reach, run.tile_grains)


def step_times(one, many, machine):
    """@param one  a run on one rank, whose phases give the costs  @return [(run, seconds measured, seconds predicted)]"""
    costs = costs_of_run(one)
    one.read_state()
    extent = one.positions.max(axis=0) - one.positions.min(axis=0) + one.mean_diameter
    out = []
    for run in many:
        steps = run.summary["steps"]
        bed = Bed(run.summary["particles"], *extent, one.summary["skin"] / one.diameter,
                  bool(one.domain.periodic[2]))
        own = dataclasses.replace(costs, steps_per_rebuild=steps / run.summary["rebuilds"])
        shape = SliceGrid.from_run(run.column("lo"), run.column("hi"), one.domain).shape
        shares = Shares(bed, shape)
        predicted = step_seconds(shares, own, dataclasses.replace(machine, threads=run.summary["threads"]))
        out.append((run, run.summary["stepping_seconds"] / steps, predicted))
    return out
