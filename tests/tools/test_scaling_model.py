#!/usr/bin/python3
# timeout: 300
# processors: 2
"""scaling-model: its halo traffic equals that of runs on 2, 4 and 8 ranks, to the byte; its step times do what they must.

Run by ctest with TALUS_BUILD_DIR and TALUS_SOURCE_DIR set, or by hand.
"""
import dataclasses
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import numpy as np

ROOT = pathlib.Path(os.environ.get("TALUS_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2])).resolve()
BUILD = pathlib.Path(os.environ.get("TALUS_BUILD_DIR", ROOT / "build/release")).resolve()
BINARY = next((str(BUILD / p) for p in ("bin/talus-sandbox", "apps/sandbox/talus-sandbox") if (BUILD / p).exists()), None)
sys.path.insert(0, str(ROOT / "tools"))
from scaling_model.bed import Bed, Shares
from scaling_model.costs import Costs, read_costs
from scaling_model.replay import Machine, losses, step_seconds
from scaling_model.subdomains import Domain, SliceGrid, choose_rank_grid
from scaling_model.traffic import halo_traffic

DIAMETER, SKIN = 1e-3, 0.1
LENGTH, DEPTH, WIDTH, HEIGHT = 0.020, 0.010, 0.0032, 0.014  # the width has room for two subdomains, and each sees its own image
CONFIG = """
[bed]
file = "bed.txt"
[box]
periodic_z = true
[shorten]
distance = 1e-4
start = "at-once"
moving = ["front"]
[engine]
tile_grains = 40
"""


def lattice(length, depth, width, seed=3):
    """Grains that do not quite stand in rows, and do not overlap."""
    counts = [int(size / (1.06 * DIAMETER)) for size in (length, depth, width)]
    axes = [(np.arange(n) + 0.5) * size / n for n, size in zip(counts, (length, depth, width))]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return points + np.random.default_rng(seed).uniform(-0.025, 0.025, points.shape) * DIAMETER


def write_bed(path):
    points = lattice(LENGTH, DEPTH, WIDTH)
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"# {len(points)} 0 {LENGTH} 0 {HEIGHT} 0 {WIDTH}\n")
        for k, (x, y, z) in enumerate(points):
            file.write(f"{k + 1} {x:.17g} {y:.17g} {z:.17g} {0.5 * DIAMETER * (1 - 0.02 * (k % 3)):.17g}\n")


def tool(*arguments):
    return subprocess.run([str(ROOT / "tools" / "scaling-model"), *map(str, arguments)], capture_output=True, text=True, check=False)


class TrafficOfRuns(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        write_bed(cls.folder / "bed.txt")
        (cls.folder / "small.toml").write_text(CONFIG)
        cls.runs = {}
        for ranks, grid in ((2, "0,0,0"), (4, "2,1,2"), (8, "2,2,2")):
            cls.runs[ranks] = cls.folder / f"ranks{ranks}"
            command = ["mpirun", "-n", ranks, "--oversubscribe", "--bind-to", "none", BINARY, "run", cls.folder / "small.toml", "--steps", 0,
                       "--threads", 1, "--out", cls.runs[ranks], "--set", f"engine.rank_grid=[{grid}]"]
            done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=120, check=False)
            if done.returncode != 0:
                raise AssertionError(done.stdout + done.stderr)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_every_rank_is_equal(self):
        done = tool("traffic", *self.runs.values())
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(done.stdout.count("equal on every rank"), 5 * len(self.runs))

    def test_runs_show_what_the_rule_is_about(self):
        found = json.loads((self.runs[4] / "summary.json").read_text())["subdomains"]
        self.assertEqual([rank["halo_messages"] for rank in found], [4] * 4)  # three others, and itself through the period
        self.assertTrue(all(rank["tiles"] > 2 for rank in found))
        self.assertTrue(any(rank["halo_bytes"] > 96 * rank["ghosts"] for rank in found))  # chunks

    def test_one_number_off_is_told(self):
        for name in ("particles", "ghosts", "tiles", "halo_messages", "halo_bytes"):
            other = self.folder / f"other-{name}"
            shutil.copytree(self.runs[2], other)
            found = json.loads((other / "summary.json").read_text())
            found["subdomains"][1][name] += 1
            (other / "summary.json").write_text(json.dumps(found))
            done = tool("traffic", other)
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertEqual(done.stdout.count("DIFFERS, first at rank 1"), 1)

    def test_a_run_that_went_on_is_refused(self):
        other = self.folder / "went-on"
        shutil.copytree(self.runs[2], other)
        found = json.loads((other / "summary.json").read_text())
        found["steps"] = 3
        (other / "summary.json").write_text(json.dumps(found))
        done = tool("traffic", other)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1))
        self.assertIn("--steps 0", done.stderr)


class Geometry(unittest.TestCase):
    """A bed's shares beside counts of the same grains."""

    def test_shares_are_near_the_counts(self):
        length, depth, width = 0.06, 0.016, 0.05
        points = lattice(length, depth, width)
        bed = Bed(len(points), length, depth, width, SKIN, periodic_z=True)
        domain = Domain(np.zeros(3), np.array([length, depth, width]), np.array([False, False, True]))
        for shape in ((4, 1, 1), (3, 1, 4), (3, 2, 3)):
            grid = SliceGrid.equal_counts(points, shape)
            counted = halo_traffic(domain, grid, points, bed.reach())
            shares = Shares(bed, shape)
            self.assertEqual(int(shares.messages().sum()), int(counted.messages.sum()))
            # Grains in rows: a halo holds one row, or two.
            self.assertAlmostEqual(float(shares.ghosts.sum()) / int(counted.ghosts.sum()), 1.0, delta=0.35)
            self.assertEqual(int(counted.sent.sum()), int(counted.ghosts.sum()))
            self.assertLessEqual(np.ptp(counted.particles), 0.03 * len(points))

    def test_rank_grids_have_least_surface(self):
        self.assertEqual(choose_rank_grid(16, (1.0, 0.01, 1.0)), (4, 1, 4))
        self.assertEqual(choose_rank_grid(12, (6.0, 1.0, 1.0), (0, 2, 0)), (6, 2, 1))
        # A period is cut in two places at once.
        self.assertEqual(choose_rank_grid(2, (1.0, 5.0, 1.1), (0, 1, 0)), (1, 1, 2))
        self.assertEqual(choose_rank_grid(2, (1.0, 5.0, 1.1), (0, 1, 0), (False, False, True)), (2, 1, 1))
        with self.assertRaises(ValueError):
            choose_rank_grid(6, (1.0, 1.0, 1.0), (4, 0, 0))


class StepTimes(unittest.TestCase):
    bed = Bed(2.4e9, 1.0, 0.0188, 1.0)
    quiet = Machine(latency=0.0, bandwidth=math.inf, imbalance=1.0, rebuilds=False)

    def test_one_rank_has_no_traffic_and_loses_nothing(self):
        shares = Shares(self.bed, (1, 1, 1))
        self.assertEqual((float(shares.ghosts.sum()), int(shares.messages().sum()), float(shares.bytes().sum())), (0.0, 0, 0.0))
        costs = dataclasses.replace(Costs(), steps_per_rebuild=100)
        work = self.bed.grains * (costs.force + costs.integrate + (costs.binning + costs.pair_build) / 100)
        self.assertAlmostEqual(step_seconds(shares, costs, Machine()) / work, 1.0, places=12)
        for name, share in losses(shares, costs, Machine()).items():
            self.assertAlmostEqual(share, 0.0, places=12, msg=name)

    def test_without_a_network_only_pairs_twice_are_left(self):
        # A subdomain of w x h x w with four neighbours: S = 4 w h of V = w^2 h, so forces take 1 + d S / (4 V) = 1 + d / w as long.
        costs = dataclasses.replace(Costs(), pack=0.0, unpack=0.0)
        for n in (4, 16, 64):
            expected = self.bed.grains / n**2 * (costs.force * (1.0 + self.bed.diameter() * n / 1.0) + costs.integrate)
            self.assertAlmostEqual(step_seconds(Shares(self.bed, (n, 1, n)), costs, self.quiet) / expected, 1.0, places=12)

    def test_a_slower_network_is_never_better(self):
        shares = Shares(self.bed, (64, 1, 64))
        for threads in (1, 8):
            for progress in ("background", "calls"):
                machine = Machine(threads=threads, progress=progress)
                for name, worse in (("latency", (2e-6, 2e-4, 2e-2, 2e-1)), ("bandwidth", (1e11, 1e10, 1e9, 1e7))):
                    seconds = []
                    for value in worse:
                        slower = dataclasses.replace(machine, **{name: value})
                        seconds.append(step_seconds(shares, Costs(), slower))
                    self.assertEqual(seconds, sorted(seconds), f"{threads} {progress} {name}")
                    self.assertGreater(seconds[-1], 1.05 * seconds[0])
                background = step_seconds(shares, Costs(), dataclasses.replace(machine, progress="background"))
                self.assertGreaterEqual(step_seconds(shares, Costs(), dataclasses.replace(machine, progress="calls")), background)

    def test_a_late_message_is_waited_for(self):
        # Nothing to do meanwhile in tiles without ghosts: a step is its work, and then all of the way of the last message.
        shares = Shares(self.bed, (128, 1, 128))
        shares.inner, shares.early = np.zeros(shares.shape), np.zeros(shares.shape)
        costs = dataclasses.replace(Costs(), pack=0.0, unpack=0.0)
        work = step_seconds(shares, costs, self.quiet)
        late = dataclasses.replace(self.quiet, latency=1e-3, hop=0.0, bandwidth=1e9)
        sent = float(np.max(shares.bytes())) / 1e9
        self.assertAlmostEqual(step_seconds(shares, costs, late), work + 1e-3 + sent, delta=1e-9)

    def test_noise_costs_and_is_the_same_again(self):
        shares = Shares(self.bed, (16, 1, 16))
        noisy = Machine(noise=0.05)
        self.assertEqual(step_seconds(shares, Costs(), noisy), step_seconds(shares, Costs(), noisy))
        # Not much: decisions lag by a step, so a rank that was slow once has time to catch up.
        self.assertGreater(step_seconds(shares, Costs(), noisy), 1.002 * step_seconds(shares, Costs(), Machine()))

    def test_prediction_prints_and_reads_costs(self):
        with tempfile.TemporaryDirectory() as folder:
            run = {"threads": 1, "settle": None, "shorten": {"particle_steps_per_second": 8e6, "steps_per_rebuild": 50},
                   "busy": {"force": 1e-7, "integrate": 2e-8, "halo_exchange": 4e-8, "binning": 1e-7, "pair_build": 5e-7, "rebalance": 0},
                   "idle_share": 0.01}
            path = os.path.join(folder, "costs.json")
            with open(path, "w", encoding="utf-8") as file:
                json.dump({"format": 1, "machine": {"processor": "some", "ranks": 1}, "runs": [run]}, file)
            costs = read_costs(path, 4)
            self.assertEqual((costs.force, costs.pack, costs.steps_per_rebuild, costs.idle_share), (1e-7, 2e-8, 50.0, 0.01))
            picture, told = os.path.join(folder, "p.png"), os.path.join(folder, "p.json")
            done = tool("predict", "--costs", path, "--ranks", "16,64", "--no-weak", "--threads", "2", "--plot", picture, "--json", told)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertGreater(os.path.getsize(picture), 5000)
            points = json.loads(pathlib.Path(told).read_text())[0]["series"][0]["points"]
            self.assertEqual([p["ranks"] for p in points], [16, 64])
            self.assertTrue(0.9 < points[1]["efficiency"] < points[0]["efficiency"] == 1.0)
            self.assertEqual(tool("predict", "--costs", told).returncode, 2)


if __name__ == "__main__":
    unittest.main()
