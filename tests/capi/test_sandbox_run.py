#!/usr/bin/python3
# timeout: 600
# processors: 2
"""talus-sandbox end to end on a small box: what it writes, that it stops on request, and that the same bits come from a
kept bed, from three ranks, from two threads, and however often a run is watched.

Run by ctest with TALUS_BUILD_DIR and TALUS_SOURCE_DIR set, or by hand."""

import csv
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

BUILD = pathlib.Path(os.environ.get("TALUS_BUILD_DIR", "build/release")).resolve()
SOURCE = pathlib.Path(os.environ.get("TALUS_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2])).resolve()
CONFIGS = SOURCE / "apps/sandbox/configs"
BINARY = next((str(BUILD / p) for p in ("bin/talus-sandbox", "apps/sandbox/talus-sandbox") if (BUILD / p).exists()), None)
TIMEOUT = 300  # seconds, of one run
STOPPED = 6    # exit code

# About 500 grains, periodic; walls at full speed at once, so that a few hundred steps already slide.
CONFIG = """
[sand]
diameter_mean = 1e-3
diameter_half_width = 1e-4
[box]
length = 0.02
depth = 0.005
width = 0.004
periodic_z = true
[settle]
cap = 0.06
[shorten]
distance = 0.001
start = "at-once"
"""
SUMMARY_KEYS = """particles ranks threads threads_observed steps time wall_seconds particle_steps_per_second rebuilds
contacts sliding_contacts bytes_per_particle imbalance phases state_digest stages version build stopped""".split()


def sandbox(*arguments, ranks=1, code=0):
    launcher = [] if ranks == 1 else ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"]
    done = subprocess.run(launcher + [BINARY, *map(str, arguments)], capture_output=True, text=True, timeout=TIMEOUT)
    if done.returncode != code:
        raise AssertionError(f"exit code {done.returncode}, not {code}\n{done.stdout}{done.stderr}")
    return done.stdout


def summary(folder):
    return json.loads((folder / "summary.json").read_text())


class SandboxRun(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.config = cls.folder / "small.toml"
        cls.config.write_text(CONFIG)
        cls.out = cls.folder / "first"
        sandbox("run", cls.config, "--out", cls.out, "--steps", 400, "--threads", 1)
        cls.digest = summary(cls.out)["state_digest"]

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def run_again(self, name, *arguments, ranks=1):
        """The same experiment, settled anew in a folder of its own unless told otherwise; returns the folder."""
        out = self.folder / name
        sandbox("run", self.config, "--out", out, "--steps", 400, *arguments, ranks=ranks)
        return out

    def test_summary_has_every_key(self):
        found = summary(self.out)
        self.assertEqual([key for key in SUMMARY_KEYS if key not in found], [])
        self.assertEqual(found["status"], "done")
        self.assertFalse(found["stopped"])
        self.assertRegex(found["state_digest"], r"^[0-9a-f]{32}$")
        self.assertEqual([stage["name"] for stage in found["stages"]], ["fill", "settle", "friction", "shorten"])
        self.assertEqual(found["stages"][-1]["steps"], 400)
        self.assertGreater(found["contacts"], found["particles"])
        self.assertGreater(found["sliding_contacts"], 0)

    def test_walls_are_a_row_every_so_many_steps(self):
        with open(self.out / "walls.csv") as file:
            rows = list(csv.DictReader(file))
        start = summary(self.out)["shortening"]["start_step"]
        self.assertEqual([int(row["step"]) - start for row in rows], [0, 100, 200, 300, 400])
        names = ["floor", "front", "backstop"]
        self.assertEqual(list(rows[0]), ["step", "time"] + [f"{n}_{q}" for n in names for q in ("fx", "fy", "fz", "px", "py", "pz")])
        found = summary(self.out)
        gone = float(rows[-1]["front_px"]) - float(rows[0]["front_px"])
        self.assertAlmostEqual(gone, found["shortening"]["distance"], delta=1e-9)
        self.assertEqual(float(rows[-1]["backstop_px"]), 0.02)

    def test_snapshots_are_listed(self):
        series = json.loads((self.out / "run.hdf.series").read_text())
        self.assertEqual(series["file-series-version"], "1.0")
        names = [entry["name"] for entry in series["files"]]
        self.assertEqual(names, sorted(path.name for path in self.out.glob("run_*.hdf")))
        self.assertGreaterEqual(len(names), 2)
        self.assertEqual([p.name for p in self.out.iterdir() if p.name.endswith((".part", ".tmp"))], [])

    def test_kept_bed_gives_the_same_bits(self):
        out = self.folder / "kept"
        shutil.copytree(self.out, out)
        sandbox("run", self.config, "--out", out, "--steps", 400)
        found = summary(out)
        self.assertIn("kept bed", found["stages"][0]["note"])
        self.assertEqual(found["state_digest"], self.digest)

    def test_changed_sand_settles_anew(self):
        out = self.folder / "cache"
        sandbox("run", self.config, "--out", out, "--steps", 0)
        sandbox("run", self.config, "--out", out, "--steps", 0, "--set", "sand.friction=0.5", "--set", "shorten.speed=0.2")
        self.assertEqual(len(list(out.glob("settled-*.ckpt"))), 1)
        sandbox("run", self.config, "--out", out, "--steps", 0, "--set", "run.seed=2")
        self.assertEqual(len(list(out.glob("settled-*.ckpt"))), 2)

    def test_damaged_kept_bed_is_settled_anew(self):
        out = self.run_again("damaged")
        bed = next(out.glob("settled-*.ckpt"))
        whole = bed.read_bytes()
        bed.write_bytes(whole[: len(whole) // 2])
        told = sandbox("run", self.config, "--out", out, "--steps", 400)
        self.assertIn("this kept bed is not used", told)
        self.assertEqual(summary(out)["state_digest"], self.digest)

    def test_three_ranks_give_the_same_bits_and_rows(self):
        out = self.run_again("ranks", "--threads", 1, ranks=3)
        self.assertEqual(summary(out)["ranks"], 3)
        self.assertEqual(summary(out)["state_digest"], self.digest)
        self.assertEqual((out / "walls.csv").read_bytes(), (self.out / "walls.csv").read_bytes())

    def test_threads_and_watching_change_no_bits(self):
        out = self.run_again("watched", "--threads", 2, "--set", "run.walls_every=7", "--set", "run.snapshot_shortening=2e-5",
                             "--set", "run.checkpoint_every=130", "--set", "engine.skin=5e-5")
        self.assertEqual(summary(out)["threads_observed"], 2)
        self.assertEqual(summary(out)["state_digest"], self.digest)

    def test_trace_is_chrome_format(self):
        trace = self.folder / "trace.json"
        self.run_again("traced", "--trace", trace)
        text = json.loads(trace.read_text())
        events = text["traceEvents"] if isinstance(text, dict) else text
        self.assertGreater(len([event for event in events if event.get("ph") == "X"]), 0)

    def stop(self, name, number, ranks):
        out = self.folder / name
        launcher = [] if ranks == 1 else ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"]
        command = launcher + [BINARY, "run", str(self.config), "--out", str(out), "--steps", "1000000"]
        process = subprocess.Popen(command + ["--set", "shorten.speed=0.001"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   text=True)
        for _ in range(TIMEOUT * 10): # until the shortening has begun
            if (out / "walls.csv").exists() or process.poll() is not None:
                break
            time.sleep(0.1)
        time.sleep(0.5)
        process.send_signal(number)
        told, _ = process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, STOPPED, told)
        found = summary(out)
        self.assertTrue(found["stopped"])
        self.assertTrue((out / "run.ckpt").exists())
        with open(out / "walls.csv") as file:
            rows = list(csv.DictReader(file))
        last = found["shortening"]["start_step"] + found["shortening"]["steps"]
        self.assertEqual((int(rows[-1]["step"]), found["snapshots"][-1]["step"]), (last, last))

    def test_termination_stops_with_everything_written(self):
        self.stop("terminated", signal.SIGTERM, 1)
        self.stop("interrupted", signal.SIGINT, 1)

    def test_signal_through_mpirun_stops_every_rank(self):
        self.stop("told", signal.SIGUSR1, 3)

    def test_bed_file_starts_the_shortening(self):
        bed = self.folder / "bed.txt"
        bed.write_text("# 2 0 0.02 0 0.01 0 0.01\n1 0.004 0.005 0.0005 0.0005\n2 0.0050 0.005 0.0005 0.0005\n")
        out = self.folder / "bed"
        sandbox("run", CONFIGS / "bed.toml", "--out", out, "--set", f'bed.file="{bed}"', "--steps", 50, "--set", "time.step=4e-6")
        found = summary(out)
        self.assertEqual([stage["name"] for stage in found["stages"]], ["bed", "friction", "shorten"])
        self.assertEqual((found["particles"], found["steps"]), (2, 50))

    def test_configurations_have_no_faults(self):
        for path in CONFIGS.glob("*.toml"):
            if path.name != "bed.toml":
                self.assertIn("no faults", sandbox("check", path))

    def test_every_key_is_explained(self):
        head = (CONFIGS / "paper.toml").read_text()
        keys = re.findall(r"^  (\w+) ", sandbox("keys"), re.MULTILINE)
        self.assertGreater(len(keys), 50)
        self.assertEqual([key for key in keys if not re.search(rf"^# .*\b{key}\b", head, re.MULTILINE)], [])


if __name__ == "__main__":
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_mpi_yield_when_idle="1",
                      OMPI_MCA_btl_vader_single_copy_mechanism="none")
    if BINARY is None:
        sys.exit(f"no talus-sandbox below {BUILD}; set TALUS_BUILD_DIR")
    unittest.main(verbosity=2)
