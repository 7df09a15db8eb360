"""The step's task graph and messages, replayed over all ranks at once.

Every array here holds one number a rank. A firing of the graph on a rank with T threads:

  begin      when the rank has ended its last firing and the reduction that it started a firing ago is there
  1          force of tiles without ghosts, integrate of those that only such tiles surround:   inner work / T
  2          once every neighbour's message is there: all ghosts are unpacked, in parts of 1024 shared among the threads
  3          force of tiles with ghosts (with the pairs that both sides evaluate), the rest of integrate:  outer work / T,
             and a last tile that one thread still works on:  (1 - 1/T) of a tile (Graham's bound on list scheduling)
  4          messages are packed (one thread each) and put on the wire, one after the other: a message arrives a latency after
             its last byte left; what a rank sends in a step shares its bandwidth

Compute nodes go before the poll, so stage 2 never interrupts stage 1 (traces of one thread show this order, node by node).
Messages leave after stage 3: the last border tile is the last to integrate, or nearly. The reduction starts at `begin` of a
firing and is there 2 log2(R) latencies after the last rank began.
`progress = "background"` lets messages and reductions move while ranks compute. With "calls" they move only inside MPI, as Open MPI
does without help: large messages (rendezvous) start when their receiver polls, and a reduction when the last rank waits for it.
Not in the model: congestion and distance in the network, memory bandwidth shared by threads, output, snapshots and checkpoints.

A rebuild (every K steps) is a chain of collectives, so of all ranks' longest stages. They are counted in
runtime/engine_step.cpp and phase/*.cpp:
  choose_skin           1 all-reduce
  learn_costs           2
  move_cuts             when due: 1 for the extent, and up to kMostSums an axis of 16 numbers a part or more (here SUMS_OF_AXIS)
  migrate               a sparse exchange (acknowledged messages and a barrier), 1 all-reduce
  bin_grains            1 (agree)
  Halo::build           a sparse exchange of whole records
  build_pairs           1 (agree)
An all-reduce and a barrier take 2 log2(R) latencies here. Every call of step(), CALL_STEPS apart, adds collectives of its own.
"""
import dataclasses
import math

import numpy as np

from scaling_model.traffic import CHUNK_BYTES, GHOST_BYTES

RECORD_BYTES = 128 + 24  # of a ghost at a rebuild: its record and shift
SUMS_OF_AXIS = 2         # of the balance, once cuts are nearly right
PART = 1024              # ghosts that a node unpacks
FILL, STEADY = 4, 16      # firings until all wait for messages as they will; firings replayed
CALL_STEPS = 200         # run.walls_every of the paper's configuration
CALL_REDUCTIONS = 4 + 2 * 5  # require_same, agree_on_input, two at the end; two for each of five walls


@dataclasses.dataclass
class Machine:
    threads: int = 1
    latency: float = 2e-6       # s, of a message
    hop: float = None           # s, of a stage of a reduction; None: as of a message
    bandwidth: float = 10e9     # B/s of a rank, sending
    progress: str = "background"
    imbalance: float = 1.02     # slowest rank over the mean
    noise: float = 0.0          # standard deviation of a rank's speed from step to step, relative
    seed: int = 1
    rebalance_steps: float = 5000.0
    tail: bool = True           # the last tile of a firing
    rebuild_overheads: bool = True  # what a rebuild takes beyond its own work shared out
    rebuilds: bool = True

    def __post_init__(self):
        if self.hop is None:
            self.hop = self.latency


class Replay:
    def __init__(self, shares, costs, machine):
        self.s, self.c, self.m = shares, costs, machine
        self.ranks = shares.ranks()
        self.wait = 2.0 * math.log2(self.ranks) * machine.hop if self.ranks > 1 else 0.0
        self.random = np.random.default_rng(machine.seed)
        # Slower and faster ranks, evenly spread, one of them the slowest: the same ones in every replay.
        spread = np.random.default_rng(machine.seed).uniform(-1.0, 1.0, shares.shape)
        if self.ranks > 1:
            spread -= spread.mean()
            spread /= np.max(spread)
        self.slow = 1.0 + (machine.imbalance - 1.0) * spread if self.ranks > 1 else np.ones(shares.shape)

    def speed(self):
        if self.m.noise == 0.0:
            return self.slow
        return self.slow * np.maximum(0.1, 1.0 + self.m.noise * self.random.standard_normal(self.s.shape))

    def steps(self, n):
        """Seconds from a common start until the last rank has ended each of n firings."""
        s, c, m = self.s, self.c, self.m
        compute = 1.0 / (m.threads * (1.0 - c.idle_share))
        force, integrate = s.grains * c.force, s.grains * c.integrate
        first = (force * s.inner + integrate * s.early) * compute
        last = (force * (1.0 - s.inner + s.twice) + integrate * (1.0 - s.early)) * compute
        if m.tail:
            last = last + (1.0 - 1.0 / m.threads) * (force + integrate) / s.tiles / (1.0 - c.idle_share)
        unpack = s.ghosts * c.unpack / np.minimum(m.threads, np.maximum(1, np.ceil(s.ghosts / PART)))
        end, arrived, reduced, ends = np.zeros(s.shape), np.zeros(s.shape), 0.0, []
        for step in range(n):
            slow = self.speed()
            if m.progress == "calls":
                reduced = float(np.max(end)) + self.wait
            begin = np.maximum(end, reduced)
            if m.progress == "background":
                reduced = float(np.max(begin)) + self.wait
            done = begin + first * slow
            if m.progress == "calls" and step > 0:
                # Nothing but the envelope has moved before the receiver looks; then all comes through its own link.
                arrived = np.maximum(arrived, done + m.latency) + s.bytes() / m.bandwidth
            done = np.maximum(done, arrived) + unpack * slow + last * slow
            end, arrived = self.send(done, slow)
            ends.append(float(np.max(end)))
        return ends

    def send(self, ready, slow):
        """Messages leave as they are packed. @return when each rank is done, and when each has all it waits for"""
        s, c, m = self.s, self.c, self.m
        arrived = np.zeros(s.shape)
        packed, free = ready.copy(), ready.copy()
        if not s.send:
            return packed, arrived
        hands = np.minimum(m.threads, np.maximum(s.messages(), 1))
        for way, (ghosts, chunks, there) in s.send.items():
            packed = packed + ghosts * c.pack * slow / hands
            sent = (GHOST_BYTES * ghosts + CHUNK_BYTES * chunks) / m.bandwidth
            free = np.where(there, np.maximum(packed, free) + sent, free)
            at = packed if m.progress == "calls" else free
            arrived = np.maximum(arrived, moved(np.where(there, at + m.latency, 0.0), way, s.periodic))
        return packed, arrived

    def rebuild(self):
        """Seconds of a rebuild, all ranks."""
        s, c, m, slow = self.s, self.c, self.m, self.slow
        compute = 1.0 / (m.threads * (1.0 - c.idle_share))
        binning, pairs = s.grains * c.binning * compute * slow, s.grains * c.pair_build * compute * slow
        if self.ranks == 1 or not m.rebuild_overheads:
            return float(np.max(binning + pairs))
        exchange = 2.0 * m.latency + self.wait  # acknowledged messages, then the barrier
        time = 3 * self.wait                                                        # choose_skin, learn_costs
        time += float(np.max(s.grains * c.migrate_scan * slow)) + exchange + self.wait
        time += float(np.max(binning)) + self.wait
        build = (s.grains * c.halo_scan + s.ghosts * c.halo_ghost) * slow
        time += float(np.max(build + s.ghosts * RECORD_BYTES / m.bandwidth)) + exchange
        time += float(np.max(pairs * (1.0 + s.twice))) + self.wait
        return time

    def rebalance(self):
        """Seconds that moving the cuts adds to a rebuild."""
        if self.ranks == 1 or not self.m.rebuild_overheads:
            return 0.0
        nx, ny, nz = self.s.shape
        time = self.wait
        for parts, groups in ((nx, 1), (nz, nx), (ny, nx * nz)):
            if parts > 1:
                numbers = 16 * parts * groups
                time += SUMS_OF_AXIS * (self.wait + 2 * 8 * numbers / self.m.bandwidth)  # reduced, then given back
        return time

    def step_seconds(self):
        """Mean seconds of a step, rebuilds, moves of cuts and calls shared over the steps between them."""
        # Without noise steps are soon alike: those after the first show it.
        ends = self.steps(STEADY if self.m.noise == 0.0 else max(STEADY, round(self.c.steps_per_rebuild)))
        seconds = (ends[-1] - ends[FILL - 1]) / (len(ends) - FILL)
        if self.m.rebuilds:
            seconds += self.rebuild() / self.c.steps_per_rebuild + self.rebalance() / self.m.rebalance_steps
        return seconds + CALL_REDUCTIONS * self.wait / CALL_STEPS


def moved(values, way, periodic):
    """What each rank gets from the rank that it lies `way` of; zero where there is none."""
    for axis, step in enumerate(way):
        if step == 0:
            continue
        values = np.roll(values, step, axis)
        if not periodic[axis]:
            edge = [slice(None)] * 3
            edge[axis] = 0 if step > 0 else -1
            values = values.copy()
            values[tuple(edge)] = 0.0
    return values


# What bounds a run: each loss is what a step gains when it is taken away and all else is kept.
LOSSES = ("pairs twice", "halo copies", "latency", "bandwidth", "reduction", "rebuild", "last tile", "imbalance")


def step_seconds(shares, costs, machine):
    return Replay(shares, costs, machine).step_seconds()


def losses(shares, costs, machine):
    """@return {loss: share of a step's time}"""
    change = dataclasses.replace
    without = {
        "pairs twice": (shares.once(), costs, machine),
        "halo copies": (shares, change(costs, pack=0.0, unpack=0.0), machine),
        "latency": (shares, costs, change(machine, latency=0.0)),
        "bandwidth": (shares, costs, change(machine, bandwidth=math.inf)),
        "reduction": (shares, costs, change(machine, hop=0.0)),
        "rebuild": (shares, costs, change(machine, rebuild_overheads=False)),
        "last tile": (shares, costs, change(machine, tail=False)),
        "imbalance": (shares, costs, change(machine, imbalance=1.0, noise=0.0)),
    }
    whole = step_seconds(shares, costs, machine)
    return {name: 1.0 - step_seconds(*without[name]) / whole for name in LOSSES}
