"""Talus from Python: spheres with friction and rolling resistance, the same bits on any threads and ranks.

    import talus

    with talus.Engine(domain_lo=(0, 0, 0), domain_hi=(0.1, 0.2, 0.1), periodic=(1, 0, 1), time_step=1e-5) as engine:
        sand = engine.add_material(young=5e6, poisson=0.25, density=2650)
        engine.set_contact(sand, sand, restitution=0.5, friction=0.5, rolling_friction=0.05)
        floor = engine.add_wall(material=sand, point=(0, 0, 0), normal=(0, 1, 0))
        engine.fill(material=sand, lo=(0, 0, 0), hi=(0.1, 0.2, 0.1), radius_min=1.5e-3, radius_max=2e-3)
        engine.step(1000)
        print(engine.state().kinetic_energy, engine.wall(floor).force)
        height = engine.view("position")[:, 1].max()
        speeds = engine.copy("velocity")          # in the order of engine.copy("label")

Units      SI; angles in radian. What each member of a struct means is said in talus.h.
Structs    Settings, Laws, Material, Contact, Wall and Fill are made of keywords over the library's defaults; every method
           that takes one takes its keywords too. Choices are given as text: Laws(normal="linear", rolling="none").
Errors     one class a status, below TalusError (see talus.errors), with the library's text. A name that a struct does not
           have is a TypeError that tells the right ones.
Grains     copy() and gather() give arrays ordered by label; view() shows the engine's own memory without a copy and raises
           StaleView once the engine has moved on.
Ranks      Engine(settings, comm=MPI.COMM_WORLD) with mpi4py. A [collective] method must be called by every rank, in the
           same order, with the same arguments unless said. Close a parallel engine (or use `with`) on every rank.
Threads    every call releases the GIL. One engine takes one caller at a time, and refuses a second with BusyError; several
           engines may step in several threads at once. request_stop() may be called from any thread.
Library    see talus._library: $TALUS_LIBRARY, then the one installed with the package, then the system's.
"""

from . import errors
from ._constants import CONTACT_FIELDS, FIELDS, WALL_LABEL, ContactField, Damping, Field, Group, Normal, Rebalance, Rolling, RollingRadius, Status, Tangential
from ._observe import InternalForce, Stress
from ._structs import Contact, Energy, Fill, Laws, Material, Memory, Phase, Rank, Settings, State, Wall, WallState
from .engine import Engine, Kept, build_info, rank_grid, status_string, version
from .errors import (ArgumentError, BusyError, CapacityError, ClosedError, CommError, FileError, InternalError, LostError,
                     StaleArrayWarning, StaleView, StateError, TalusError, UnstableError, UnsupportedError)
from .view import View

__all__ = [
    "Engine", "Kept", "View", "errors",
    "Settings", "Laws", "Material", "Contact", "Wall", "Fill",
    "State", "Energy", "WallState", "Rank", "Phase", "Stress", "InternalForce",
    "Status", "Normal", "Damping", "Tangential", "Rolling", "RollingRadius", "Rebalance", "Group", "Field", "FIELDS",
    "ContactField", "CONTACT_FIELDS", "WALL_LABEL", "Memory",
    "TalusError", "ArgumentError", "StateError", "UnstableError", "LostError", "FileError", "CommError", "CapacityError",
    "UnsupportedError", "InternalError", "ClosedError", "BusyError", "StaleView", "StaleArrayWarning",
    "rank_grid", "version", "build_info", "status_string",
]
