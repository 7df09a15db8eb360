"""Finds the package in the source tree and the library in the build tree.

By ctest, or by hand: TALUS_LIBRARY=.../libtalus.so /usr/bin/python3 -m pytest tests/python"""

import os
import pathlib
import sys

import pytest

SOURCE = pathlib.Path(os.environ.get("TALUS_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2])).resolve()
PACKAGE = SOURCE / "capi/python"
SKIPPED = 77  # as tests/register.cmake has it

if os.environ.get("TALUS_SANITIZE"):
    print("skipped: an instrumented library cannot be loaded by a plain Python", file=sys.stderr)
    sys.exit(SKIPPED)  # pytest.exit() is not heard while conftest.py is being read
if "TALUS_LIBRARY" not in os.environ:
    build = pathlib.Path(os.environ.get("TALUS_BUILD_DIR", SOURCE / "build/release"))
    os.environ["TALUS_LIBRARY"] = str((build / "lib/libtalus.so").resolve())
# For programs that tests start, too.
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(PACKAGE), os.environ.get("PYTHONPATH")]))
sys.path.insert(0, str(PACKAGE))
sys.dont_write_bytecode = True

import numpy as np  # noqa: E402
import talus  # noqa: E402

RADIUS = 1e-3


def settings(**values):
    """A box of 4 cm without gravity, unless told otherwise."""
    given = dict(domain_lo=(0, 0, 0), domain_hi=(0.04, 0.04, 0.04), time_step=2e-6, gravity=(0, 0, 0))
    return talus.Settings(**(given | values))


def prepared(restitution=0.5, friction=0.5, wall=True, young=5e6, **values):
    """An engine with one material and a floor at y = 0, without grains."""
    engine = talus.Engine(settings(**values))
    sand = engine.add_material(young=young, poisson=0.2, density=2500)
    engine.set_contact(sand, sand, restitution=restitution, friction=friction, rolling_friction=0.01)
    if wall:
        engine.add_wall(material=sand, point=(0, 0, 0), normal=(0, 1, 0))
    return engine


def bed(n=200, **values):
    """Some grains that fall onto the floor; labels are given in an order that is not the sorted one."""
    engine = prepared(gravity=(0, -9.81, 0), **values)
    place = np.stack(np.unravel_index(np.arange(n), (10, (n + 99) // 100, 10)), axis=1)
    label = np.random.default_rng(1).permutation(n) * 3 + 5
    engine.insert(label, 2.2e-3 + 2.5e-3 * place, RADIUS)
    return engine


@pytest.fixture
def world():
    with bed() as engine:
        yield engine
