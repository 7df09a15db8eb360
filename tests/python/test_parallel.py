# processors: 2
"""Engines over an mpi4py communicator: the same bits as a serial one, the same errors on every rank, and no hang."""

import os
import shutil
import subprocess
import sys

import pytest

pytest.importorskip("mpi4py")
if not shutil.which("mpirun"):
    pytest.skip("there is no mpirun", allow_module_level=True)

# ctest sets these for every test (tests/register.cmake); by hand they are needed as well.
OPEN_MPI = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_mpi_yield_when_idle": "1"}

PRELUDE = """
from mpi4py import MPI
import numpy as np, talus
from conftest import settings, RADIUS
comm = MPI.COMM_WORLD
rank = comm.rank
def make(comm):
    engine = talus.Engine(settings(gravity=(0, -9.81, 0)), comm=comm)
    sand = engine.add_material(young=5e6, poisson=0.2, density=2500)
    engine.set_contact(sand, sand, restitution=0.5, friction=0.5)
    engine.add_wall(material=sand, point=(0, 0, 0), normal=(0, 1, 0))
    engine.fill(material=sand, lo=(0, 0, 0), hi=(0.04, 0.02, 0.04), radius_min=8e-4, radius_max=1e-3)
    return engine
"""


def on_two_ranks(program):
    command = ["mpirun", "-n", "2", "--oversubscribe", "--bind-to", "none", sys.executable, "-B", "-c", PRELUDE + program]
    here = os.path.dirname(os.path.abspath(__file__))
    path = os.pathsep.join([here, os.environ["PYTHONPATH"]])
    done = subprocess.run(command, env=os.environ | OPEN_MPI | {"PYTHONPATH": path}, cwd=here, capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stdout + done.stderr
    return done


def test_two_ranks_have_the_bits_of_one():
    on_two_ranks("""
with make(comm) as both, make(None) as alone:
    for engine in (both, alone):
        engine.step(300)
    assert (both.rank, both.size) == (rank, 2)
    assert both.state().digest == alone.state().digest
    own, all_ = both.copy("label"), both.gather("position")
    assert 0 < len(own) < alone.state().particles
    assert (np.diff(own) > 0).all() and (both.copy("owner") == rank).all()
    if rank == 0:
        assert (all_ == alone.copy("position")).all()
    else:
        assert all_.shape == (0, 3)
    assert [r.rank for r in both.ranks()] == [0, 1]
    assert len(both.view("position")) == len(own)
""")


def test_a_fault_on_one_rank_is_an_error_on_both_and_nobody_waits():
    on_two_ranks("""
with make(comm) as engine:
    before = engine.state().particles
    try:
        engine.insert([10**6 + rank], [[0.01] * (3 if rank else 2)], RADIUS)
    except talus.ArgumentError as error:
        assert rank == 1, error
    except ValueError as error:
        assert rank == 0 and "position" in str(error)
    else:
        raise SystemExit("no error")
    assert engine.state().particles == before
    engine.step(5)
""")


def test_an_engine_that_was_not_closed_does_not_hang():
    done = on_two_ranks("""
import gc, warnings
warnings.simplefilter("always")
engine = make(comm)
engine.step(1)
if rank == 0:
    del engine
    gc.collect()
comm.Barrier()
""")
    assert "was not closed" in done.stderr
