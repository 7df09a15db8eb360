#!/usr/bin/python3
# timeout: 600
# processors: 2
"""talus-sandbox plan: what it foretells of a small run against that run, its JSON, the costs that --calibrate keeps, and its errors.

Wall times are not compared: machines that run tests are shared. Run by ctest with TALUS_BUILD_DIR and TALUS_SOURCE_DIR set, or by
hand."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

BUILD = pathlib.Path(os.environ.get("TALUS_BUILD_DIR", "build/release")).resolve()
SOURCE = pathlib.Path(os.environ.get("TALUS_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2])).resolve()
CONFIGS = SOURCE / "apps/sandbox/configs"
BINARY = next((str(BUILD / p) for p in ("bin/talus-sandbox", "apps/sandbox/talus-sandbox") if (BUILD / p).exists()), None)
TIMEOUT = 300  # seconds, of one call
RANKS = 4

# About 4000 grains, periodic; it never comes to rest, so that settling takes as many steps as it may.
CONFIG = """
[run]
snapshot_shortening = 0.0003
walls_every = 50
[sand]
diameter_mean = 1e-3
diameter_half_width = 1e-4
[box]
length = 0.06
depth = 0.006
width = 0.01
periodic_z = true
[time]
step_fraction = 0.3
[settle]
cap = 0.08
kinetic = 1e-12
restitution = 0.05
[shorten]
distance = 0.001
start = "at-once"
"""


def call(*arguments, ranks=1, code=0, env=None):
    launcher = [] if ranks == 1 else ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"]
    done = subprocess.run(launcher + [BINARY, *map(str, arguments)], capture_output=True, text=True, timeout=TIMEOUT, env=env)
    if done.returncode != code:
        raise AssertionError(f"exit code {done.returncode}, not {code}\n{done.stdout}{done.stderr}")
    return done


class SandboxPlan(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        # No costs of whoever runs the tests.
        os.environ["XDG_CACHE_HOME"] = str(cls.folder / "cache")
        cls.config = cls.folder / "small.toml"
        cls.config.write_text(CONFIG)
        cls.out = cls.folder / "run"
        call("run", cls.config, "--out", cls.out, "--threads", 1, ranks=RANKS)
        cls.found = json.loads((cls.out / "summary.json").read_text())
        cls.costs = cls.folder / "costs.json"
        call("plan", cls.config, "--calibrate", "--costs", cls.costs, "--threads", 2)
        cls.plan = cls.forecast(cls.config, "--costs", cls.costs, "--ranks", RANKS, "--threads", 1)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def forecast(cls, *arguments, ranks=1):
        return json.loads(call("plan", *arguments, "--json", "-", ranks=ranks).stdout)

    def near(self, foretold, found, share):
        self.assertLess(abs(foretold - found), share * found, f"{foretold} foretold, {found} found")

    def test_grains_and_steps_are_those_of_the_run(self):
        stages = {stage["name"]: stage for stage in self.found["stages"]}
        self.assertEqual(self.plan["grains"], self.found["particles"])
        self.assertEqual(self.plan["time_step"], self.found["time_step"])
        self.assertEqual(self.plan["settle"]["steps"], stages["settle"]["steps"])
        self.assertEqual(self.plan["settle"]["cap_steps"], stages["settle"]["steps"])
        self.assertEqual(self.plan["shorten"]["steps"], stages["shorten"]["steps"])

    def test_files_are_as_many_and_as_large(self):
        files = self.plan["files"]
        snapshots = sorted(self.out.glob("run_*.hdf"))
        self.assertEqual((files["snapshots"], files["checkpoints"]), (len(snapshots), 1))
        self.near(files["snapshot_bytes"], snapshots[0].stat().st_size, 0.05)
        self.near(files["checkpoint_bytes"], (self.out / "run.ckpt").stat().st_size, 0.1)
        self.near(files["settled_bed_bytes"], next(self.out.glob("settled-*.ckpt")).stat().st_size, 0.1)
        self.near(files["walls_bytes"], (self.out / "walls.csv").stat().st_size, 0.15)
        self.near(files["bytes_on_disk"], sum(p.stat().st_size for p in self.out.iterdir() if p.name != "summary.json"), 0.1)

    def test_halo_is_that_of_the_run(self):
        self.assertEqual(self.plan["subdomains"]["grid"], [4, 1, 1])
        self.near(self.plan["halo"]["ghosts"], self.found["ghosts"], 0.3)
        self.assertEqual(self.plan["halo"]["messages_per_step"], 2)
        # 96 bytes a ghost, and as much a tile near the border.
        bytes_of_ghosts = 96 * self.plan["halo"]["ghosts"]
        self.assertGreater(self.plan["halo"]["bytes_per_step"], bytes_of_ghosts)
        self.assertLess(self.plan["halo"]["bytes_per_step"], 1.1 * bytes_of_ghosts)

    def test_memory_is_of_the_right_size(self):
        self.near(self.plan["memory"]["rank_bytes"], self.found["peak_bytes"], 0.5)
        self.assertGreater(self.plan["memory"]["bytes"], 3 * self.plan["memory"]["rank_bytes"])

    def test_costs_are_kept(self):
        costs = json.loads(self.costs.read_text())
        self.assertEqual(costs["format"], 1)
        self.assertEqual([run["threads"] for run in costs["runs"]], [1, 2])
        for run in costs["runs"]:
            for stage in ("settle", "shorten"):
                self.assertGreater(run[stage]["particle_steps_per_second"], 1e4)
            self.assertGreater(run["busy"]["force"], 1e-9)
            self.assertIsNone(run["busy"]["halo_exchange"])
            self.assertTrue(0 <= run["idle_share"] < 1)
        self.near(costs["scene"]["contacts_per_grain"], self.found["contacts"] / self.found["particles"], 0.15)
        self.assertEqual([p.name for p in self.folder.glob("costs*")], ["costs.json"])
        self.assertTrue(self.plan["costs"]["is_of_this_machine"])
        self.assertTrue(self.plan["settle"]["is_measured"])

    def test_two_ranks_measure_halos_and_one_speaks(self):
        costs = self.folder / "halo.json"
        plan = self.forecast(self.config, "--calibrate", "--costs", costs, "--threads", 1, ranks=2)
        self.assertEqual(plan["ranks"], 2)
        self.assertGreater(json.loads(costs.read_text())["runs"][0]["busy"]["halo_exchange"], 0)
        self.assertNotIn("reference value", " ".join(plan["assumptions"]))

    def test_default_file_is_in_the_cache(self):
        (self.folder / "cache").mkdir(exist_ok=True)
        kept = self.folder / "cache" / "talus-costs.json"
        try:
            kept.write_text(self.costs.read_text())
            self.assertEqual(self.forecast(self.config)["costs"]["file"], str(kept))
        finally:
            kept.unlink()
        told = call("plan", self.config).stdout
        self.assertIn("NOT OF THIS MACHINE", told)
        self.assertIn("--calibrate", told)

    def test_the_paper_on_its_machine(self):
        for name, grains in (("paper.toml", 1.9e9), ("paper-2x.toml", 0.238e9)):
            plan = self.forecast(CONFIGS / name, "--ranks", 16384, "--threads", 8)
            self.near(plan["grains"], grains, 0.02)
            self.assertEqual(plan["subdomains"]["grid"][0] * plan["subdomains"]["grid"][1] * plan["subdomains"]["grid"][2], 16384)
            self.assertGreater(plan["halo"]["ghosts"], 1000)
            self.assertGreater(plan["shorten"]["wall_seconds"], 100)
            self.assertGreater(plan["files"]["bytes_on_disk"], 85 * plan["grains"] * plan["files"]["snapshots"])

    def test_network_and_disk_are_taken_as_stated(self):
        arguments = (self.config, "--costs", self.costs, "--ranks", RANKS, "--threads", 1)
        slow = self.forecast(*arguments, "--latency", 1e-3, "--bandwidth", 1e6, "--disk", 1e3)
        step = 2e-3 + slow["halo"]["bytes_per_step"] / 1e6
        self.assertAlmostEqual(slow["shorten"]["network_seconds"], slow["shorten"]["steps"] * step, delta=1e-6)
        self.assertAlmostEqual(slow["file_seconds"], slow["files"]["bytes_written"] / 1e3, delta=1e-3)
        self.assertGreater(slow["wall_seconds"], self.plan["wall_seconds"])

    def test_json_may_be_a_file(self):
        path = self.folder / "plan.json"
        told = call("plan", self.config, "--json", path).stdout
        self.assertIn("assumed", told)
        self.assertEqual(json.loads(path.read_text())["grains"], self.plan["grains"])
        call("plan", self.config, "--json", self.folder / "nowhere" / "plan.json", code=4)

    def test_bad_costs_are_clear_errors(self):
        whole = self.costs.read_text()
        zero = json.loads(whole)
        zero["runs"][0]["shorten"]["particle_steps_per_second"] = 0
        without = json.loads(whole)
        del without["memory"]["bytes_per_grain"]
        cases = {
            "missing": (None, "cannot be opened"),
            "other format": ('{"format": 99}', "format = 99: this program reads format 1"),
            "damaged": (whole[: len(whole) // 2], "is damaged"),
            "not JSON": ("[sand]\n", "is damaged"),
            "a list": ("[1, 2]", "format: is missing"),
            "zero": (json.dumps(zero), "runs[0].shorten.particle_steps_per_second = 0: must be a finite number above 0"),
            "lacking": (json.dumps(without), "memory.bytes_per_grain: is missing"),
        }
        for name, (text, expect) in cases.items():
            with self.subTest(name):
                path = self.folder / "bad.json"
                path.unlink(missing_ok=True)
                if text is not None:
                    path.write_text(text)
                told = call("plan", self.config, "--costs", path, code=2)
                self.assertIn(expect, told.stderr)
                self.assertIn("bad.json", told.stderr)
                self.assertIn("--calibrate", told.stderr)
                self.assertEqual(told.stdout, "")

    def test_bad_input_is_a_clear_error_of_one_rank(self):
        cases = [
            (["--ranks", 0], "--ranks"),
            (["--ranks", 1000000], "subdomains would be narrower"),
            (["--ranks", 8, "--set", "engine.rank_grid=[3, 0, 0]"], "engine.rank_grid"),
            (["--ranks", 64, "--set", "engine.rank_grid=[64, 1, 1]"], "64 subdomains along x"),
            (["--bandwidth", 0], "--bandwidth"),
            (["--latency", -1], "--latency"),
            (["--set", "sand.friction=-1"], "sand.friction"),
        ]
        for arguments, expect in cases:
            for ranks in (1, 2):
                with self.subTest(expect, ranks=ranks):
                    told = call("plan", self.config, *arguments, ranks=ranks, code=2)
                    self.assertEqual(told.stderr.count(expect), 1, told.stderr)
        self.assertIn("cannot be written", call("plan", self.config, "--calibrate", "--costs", self.config / "x" / "costs.json", code=4).stderr)


if __name__ == "__main__":
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_mpi_yield_when_idle="1",
                      OMPI_MCA_btl_vader_single_copy_mechanism="none")
    if BINARY is None:
        sys.exit(f"no talus-sandbox below {BUILD}; set TALUS_BUILD_DIR")
    unittest.main(verbosity=2)
