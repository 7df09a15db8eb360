# timeout: 300
"""plot-sandbox on a made-up run: a bed cut by two bands of known dip, drawn, found again and measured.

TALUS_KEEP=DIR keeps the run and its pictures there, to be looked at.
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import h5py
import numpy as np

ROOT = os.environ.get("TALUS_SOURCE_DIR", os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tools"))
from sandbox_plots import measure, strain

LENGTH, HEIGHT, DEPTH, DIAMETER = 0.12, 0.0188, 1.8e-3, 0.6e-3
DIP_RIGHT, DIP_LEFT, ROOT_X = 33.0, 41.0, 0.075
STEP, DROP = 2e-3, 0.2                   # m of shortening a snapshot; share of force lost at the fault
RISE = STEP / (1 / np.tan(np.radians(DIP_RIGHT)) + 1 / np.tan(np.radians(DIP_LEFT)))  # of the block between, a snapshot


def packed_bed(random):
    """Grains on a jittered lattice: dense enough to have neighbours everywhere, and never regular."""
    spacing = 0.98 * DIAMETER
    axes = [np.arange(0.5 * spacing, size, spacing) for size in (LENGTH, HEIGHT, DEPTH)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return points + random.uniform(-0.3, 0.3, points.shape) * spacing


def block_motion(points, active):
    """Displacement of one snapshot: sand left of both bands moves with the floor, right of them it stays, and the
    block between slides up both. Without `active` bands the bed is shortened evenly."""
    x, y = points[:, 0], points[:, 1]
    motion = np.zeros_like(points)
    if active:
        a, b = np.radians(DIP_RIGHT), np.radians(DIP_LEFT)
        width = 3 * DIAMETER
        over_right = 0.5 * (1 + np.tanh(((x - ROOT_X) * np.sin(a) + y * np.cos(a)) / width))
        over_left = 0.5 * (1 + np.tanh(((x - ROOT_X) * np.sin(b) - y * np.cos(b)) / width))
        between = np.array([STEP - RISE / np.tan(a), RISE])
        left = np.array([STEP, 0.0])
        motion[:, :2] = left + over_right[:, None] * (between - left) - over_left[:, None] * between
    else:
        motion[:, 0] = STEP * (1 - x / LENGTH)
        motion[:, 1] = y * STEP / LENGTH
    # The floor drags a thin layer along, but not into the back stop.
    motion[:, 0] += (STEP - motion[:, 0]) * np.exp(-y / DIAMETER) * (1 - np.exp((x - LENGTH) / (5 * DIAMETER)))
    return motion


def write_snapshot(path, random, step, label, points, displacement, colour):
    order = random.permutation(len(label))
    with h5py.File(path, "w") as file:
        group = file.create_group("VTKHDF")
        group["Points"] = points[order]
        data = group.create_group("PointData")
        data["label"] = label[order]
        data["radius"] = np.full(len(label), 0.5 * DIAMETER)
        data["velocity"] = np.zeros_like(points)
        data["displacement"] = displacement[order]
        data["colour"] = colour[order].astype(np.int32)
        data["owner"] = np.zeros(len(label), np.int32)
        group.create_group("FieldData")["TimeValue"] = np.array([1e-5 * step])
        file.attrs["box_lo"], file.attrs["box_hi"] = np.zeros(3), np.array([LENGTH, 3 * HEIGHT, DEPTH])
        file.attrs["periodic"] = np.array([0, 0, 1])
        file.attrs["time"], file.attrs["step"] = 1e-5 * step, step


def write_walls(path, random, snapshots):
    samples = 2000
    time = np.linspace(0.0, 0.02 * (snapshots - 1), samples)
    moved = STEP * time / 0.02
    force = 0.5 + 0.4 * (1 - np.exp(-moved / 1e-3))
    force *= 1 - DROP / (1 + np.exp(-(moved - 4.5e-3) / 1e-4))
    force += 0.01 * random.standard_normal(samples)
    columns = {"step": np.round(time / 1e-5), "time": time}
    for name in ("floor", "front", "backstop"):
        moves = name != "backstop"
        for axis in "xyz":
            columns[f"{name}_f{axis}"] = (force if name == "backstop" else -force) if axis == "x" else np.zeros(samples)
        columns[f"{name}_px"] = (moved if moves else np.full(samples, LENGTH))
        columns[f"{name}_py"] = columns[f"{name}_pz"] = np.zeros(samples)
    np.savetxt(path, np.column_stack(list(columns.values())), "%.9g", ",", header=",".join(columns), comments="")
    with open(path, "a", encoding="utf-8") as file:
        file.write("20001,0.2")  # a run that was killed


def write_run(folder, snapshots=5):
    random = np.random.default_rng(7)
    points = packed_bed(random)
    label = 10 + np.arange(len(points))
    colour = (points[:, 1] / (HEIGHT / 8)).astype(int)
    displacement = np.zeros_like(points)
    for index in range(snapshots):
        if index:
            motion = block_motion(points, active=index > 1) + 0.02 * DIAMETER * random.standard_normal(points.shape)
            points, displacement = points + motion, displacement + motion
        # Left in the name of number 10 and above: sorted by number, not by text.
        write_snapshot(os.path.join(folder, f"run_{9 + index}.hdf"), random, 2000 * index, label, points, displacement, colour)
    write_walls(os.path.join(folder, "walls.csv"), random, snapshots)
    with open(os.path.join(folder, "summary.json"), "w", encoding="utf-8") as file:
        json.dump({"particles": len(points)}, file)


def plot(folder):
    return subprocess.run([os.path.join(ROOT, "tools", "plot-sandbox"), folder], capture_output=True, text=True, check=False)


class Strain(unittest.TestCase):
    def test_pairs_equal_brute_force(self):
        random = np.random.default_rng(1)
        x, y = random.uniform(0, 3, 400), random.uniform(0, 1, 400)
        found = {(min(i, j), max(i, j)) for block in strain.cell_pairs(x, y, 0.17) for i, j in zip(*block)}
        count = sum(len(i) for i, _ in strain.cell_pairs(x, y, 0.17))
        i, j = np.triu_indices(400, 1)
        close = np.hypot(x[i] - x[j], y[i] - y[j]) < 0.17
        self.assertEqual(found, set(zip(i[close], j[close])))
        self.assertEqual(count, len(found))

    def test_affine_motion_is_recovered_exactly(self):
        random = np.random.default_rng(2)
        x, y = random.uniform(0, 20, 3000), random.uniform(0, 5, 3000)
        wanted = (0.1, -0.3, 0.2, 0.05)
        u, v = 7 + wanted[0] * x + wanted[1] * y, 3 + wanted[2] * x + wanted[3] * y
        for got, value in zip(strain.gradients(x, y, u, v, 1.0), wanted):
            np.testing.assert_allclose(got[np.isfinite(got)], value, atol=1e-10)
            self.assertGreater(np.isfinite(got).mean(), 0.99)

    def test_lonely_grains_have_no_strain(self):
        got = strain.gradients(np.array([0.0, 9.0]), np.array([0.0, 9.0]), np.ones(2), np.ones(2), 1.0)
        self.assertTrue(np.isnan(got[0]).all())


class Forces(unittest.TestCase):
    def test_a_drop_is_measured_through_its_wiggles(self):
        x = np.linspace(0, 10, 500)
        force = np.interp(x, [0, 4, 5, 8, 10], [0, 1, 0.7, 1.2, 1.15]) + 0.01 * np.sin(40 * x)
        drops = measure.drops(x, force)
        self.assertEqual(len(drops), 1)
        self.assertAlmostEqual(drops[0]["share"], 0.3, delta=0.03)
        self.assertAlmostEqual(drops[0]["from"], 4, delta=0.2)

    def test_a_rising_force_has_none(self):
        self.assertEqual(measure.drops(np.arange(9.0), np.arange(9.0)), [])


class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = os.environ.get("TALUS_KEEP", cls.temporary.name)
        os.makedirs(cls.folder, exist_ok=True)
        write_run(cls.folder)
        cls.outcome = plot(cls.folder)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_all_pictures_are_written_and_named(self):
        self.assertEqual(self.outcome.returncode, 0, self.outcome.stderr)
        self.assertEqual(self.outcome.stderr, "")
        for name in ("section.png", "shear.png", "spin.png", "forces.png", "faults.png"):
            self.assertGreater(os.path.getsize(os.path.join(self.folder, name)), 10000)
            self.assertIn(name, self.outcome.stdout)

    def test_bands_uplift_and_drop_are_those_put_in(self):
        with open(os.path.join(self.folder, "faults.json"), encoding="utf-8") as file:
            found = json.load(file)
        self.assertGreater(found["clearest_increment"], 0)
        self.assertLess(found["increments"][0]["clarity"], 2.0)
        best = found["increments"][found["clearest_increment"]]
        bands = {band["dips_to"]: band for band in best["bands"]}
        for side, dip in (("right", DIP_RIGHT), ("left", DIP_LEFT)):
            self.assertAlmostEqual(bands[side]["dip_deg"], dip, delta=3.0)
            self.assertAlmostEqual(bands[side]["dip_from_structure_tensor_deg"], dip, delta=5.0)
            self.assertGreater(bands[side]["ratio_to_background"], 3.0)
        rise = 3 * 1e3 * RISE + 1e3 * HEIGHT * STEP / LENGTH
        self.assertAlmostEqual(found["uplift_at_end_mm"], rise, delta=0.1 * rise)
        self.assertAlmostEqual(found["largest_drop_percent"], 100 * DROP, delta=3.0)
        self.assertEqual(len(found["backstop_force_drops"]), 1)

    def test_a_folder_without_a_run_is_refused_in_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            outcome = plot(folder)
            self.assertNotEqual(outcome.returncode, 0)
            self.assertIn(folder, outcome.stderr)
            self.assertEqual(outcome.stderr.count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
