"""A run of talus-sandbox on disk, as far as its decomposition goes: run.ckpt and summary.json.

The lists of a run are those of the saved positions if no step was taken since they were built: `run CONFIG --steps 0`, from a
bed file or a kept bed.
"""
import json
import os

import h5py
import numpy as np

from scaling_model.subdomains import Domain, SliceGrid


class RunError(Exception):
    """The folder does not hold what is needed; the text says what and where."""


class Run:
    def __init__(self, folder):
        self.folder = folder
        try:
            with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
                self.summary = json.load(file)
        except (OSError, ValueError) as fault:
            raise RunError(f"{folder}: has no readable summary.json ({fault})") from fault
        for key in ("subdomains", "skin", "halo", "phases"):
            if key not in self.summary:
                raise RunError(f"{folder}: summary.json has no '{key}': the run did not end well, or Talus is older than this tool")
        self.ranks = self.summary["ranks"]

    def column(self, name):
        return np.array([rank[name] for rank in self.summary["subdomains"]])

    def read_state(self):
        """Positions, labels, contacts, domain and sizes of grains, as the checkpoint has them."""
        path = os.path.join(self.folder, "run.ckpt")
        try:
            with h5py.File(path, "r") as file:
                self.positions = file["grains/position"][:]
                self.labels = file["grains/label"][:]
                self.mean_diameter = 2.0 * float(np.mean(file["grains/radius"][:]))
                state = file["state"]
                self.domain = Domain(state["domain/lo"][:], state["domain/hi"][:], state["domain/periodic"][:].astype(bool))
                self.diameter = 2.0 * float(state["radius_max"][()])
                self.partners = file["contacts/partner"][:]
                self.partner_number = file["contacts/number"][:]
        except (OSError, KeyError) as fault:
            raise RunError(f"{path}: not a checkpoint of talus-sandbox ({fault})") from fault

    def read_lists(self):
        """And what lists follow from: reach and cuts. Only of a run whose lists are those of its checkpoint."""
        if self.summary["steps"] != 0:
            raise RunError(f"{self.folder}: {self.summary['steps']} steps were taken, so grains have left the places that lists were "
                           "built from; run with --steps 0 from a bed file or a kept bed")
        self.read_state()
        self.reach = self.diameter + self.summary["skin"]
        self.tile_grains = self.summary["configuration"]["engine"]["tile_grains"]
        try:
            self.grid = SliceGrid.from_run(self.column("lo"), self.column("hi"), self.domain)
        except ValueError as fault:
            raise RunError(f"{self.folder}: {fault}") from fault

    def contact_pairs(self):
        """Contacts between grains, each once, as pairs of rows."""
        row = np.repeat(np.arange(len(self.labels)), self.partner_number)
        grain = self.partners < 2**62  # the others are walls
        order = np.argsort(self.labels)
        partner = order[np.searchsorted(self.labels, self.partners[grain], sorter=order)]
        once = row[grain] < partner
        return np.column_stack([row[grain][once], partner[once]])
