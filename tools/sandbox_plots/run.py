"""A sandbox run on disk: its snapshots, wall forces and summary, in SI units.

x is the direction of shortening, y is up, z runs along the trench. Snapshots hold their grains in any order: they are
sorted by label here, so that two of them can be compared row by row after `matched`.
"""
import glob
import json
import os
import re

import h5py
import numpy as np


class RunError(Exception):
    """The folder does not hold what a picture needs; the text says what and where."""


class Snapshot:
    """Grains at one moment: label, x, y, z, radius, ux, uy, colour; all arrays of the same length."""

    def __init__(self, path):
        self.path = path
        try:
            with h5py.File(path, "r") as file:
                group = file["VTKHDF"]
                points = group["Points"][:]
                data = group["PointData"]
                label = data["label"][:]
                order = np.argsort(label, kind="stable")
                self.label = label[order]
                self.x, self.y, self.z = (points[order, axis].astype(float) for axis in range(3))
                self.radius = data["radius"][:][order].astype(float)
                displacement = data["displacement"][:][order].astype(float)
                self.colour = data["colour"][:][order].astype(int)
                self.time = float(file.attrs["time"])
                self.step = int(file.attrs["step"])
        except (OSError, KeyError) as fault:
            raise RunError(f"{path}: not a snapshot of talus-sandbox ({fault})") from fault
        if len(self.label) == 0:
            raise RunError(f"{path}: holds no grains")
        self.ux, self.uy = displacement[:, 0], displacement[:, 1]

    def keep(self, rows):
        for name in ("label", "x", "y", "z", "radius", "ux", "uy", "colour"):
            setattr(self, name, getattr(self, name)[rows])


class Walls:
    """The table walls.csv: force on each wall and a point of it, over time."""

    def __init__(self, path):
        try:
            with open(path, encoding="utf-8") as file:
                names = file.readline().strip().lstrip("#").replace(" ", "").split(",")
                # A run that was killed may end in half a line, which must not hide the rest.
                rows = [row for row in (line.strip().split(",") for line in file) if len(row) == len(names)]
        except OSError as fault:
            raise RunError(f"{path}: cannot be read ({fault.strerror})") from fault
        if "time" not in names or not rows:
            raise RunError(f"{path}: has no header with a column 'time', or no rows")
        table = np.array(rows, float)
        self.columns = {name: table[:, index] for index, name in enumerate(names)}
        self.time = self.columns["time"]

    def names(self):
        return [name[:-3] for name in self.columns if name.endswith("_fx")]

    def force(self, wall, axis):
        return self.columns[f"{wall}_f{axis}"]

    def point(self, wall, axis):
        for name in (f"{wall}_p{axis}", f"{wall}_{axis}"):
            if name in self.columns:
                return self.columns[name]
        raise RunError(f"walls.csv: no column {wall}_p{axis}")


class Run:
    """The folder of one run. Snapshots are reduced to a slab in the middle of z when the box is deep."""

    # Deeper than this many diameters along z, overlaid grains would blur the section and its strain.
    slab_diameters = 6.0

    def __init__(self, folder):
        self.folder = folder
        paths = sorted(glob.glob(os.path.join(folder, "run_*.hdf")),
                       key=lambda path: [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", path)])
        if len(paths) < 2:
            raise RunError(f"{folder}: {len(paths)} snapshots run_*.hdf found, two or more are needed")
        self.snapshots = sorted((Snapshot(path) for path in paths), key=lambda snapshot: snapshot.step)
        self.walls = Walls(os.path.join(folder, "walls.csv"))
        self.summary = {}
        if os.path.exists(os.path.join(folder, "summary.json")):
            with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
                self.summary = json.load(file)

        first = self.snapshots[0]
        self.diameter = 2.0 * float(np.mean(first.radius))
        depth = float(first.z.max() - first.z.min()) + self.diameter
        self.slab = depth > 1.5 * self.slab_diameters * self.diameter
        if self.slab:
            middle = 0.5 * (first.z.max() + first.z.min())
            for snapshot in self.snapshots:
                snapshot.keep(np.abs(snapshot.z - middle) < 0.5 * self.slab_diameters * self.diameter)
            depth = self.slab_diameters * self.diameter
        self.depth = depth

    def wall_x(self, wall, time):
        return float(np.interp(time, self.walls.time, self.walls.point(wall, "x")))

    def shortening(self, time):
        """How far the front wall has come since the first snapshot, in m."""
        return self.wall_x("front", time) - self.wall_x("front", self.snapshots[0].time)


def matched(before, after):
    """Rows of the grains that both snapshots hold, in the same order."""
    _, rows_before, rows_after = np.intersect1d(before.label, after.label, assume_unique=True, return_indices=True)
    return rows_before, rows_after
