"""The engine: make, step, save, end."""

from __future__ import annotations

import ctypes
import os
from ctypes import c_int64, c_void_p
from typing import Any, Optional, Union

from . import _arrays
from ._constants import SERIAL
from ._functions import bind  # noqa: F401  (the prototypes must stand before any call)
from ._grains import Grains
from ._handle import raise_for, stopped
from ._library import lib
from ._observe import Observer
from ._setup import Setup
from ._struct import given
from ._structs import Settings
from .errors import TalusError

Path = Union[str, bytes, "os.PathLike[str]"]


def handle_of(comm: Any) -> int:
    """The Fortran handle of an mpi4py communicator, or of whoever has a py2f(); a whole number is taken as one."""
    if hasattr(comm, "py2f"):
        return int(comm.py2f())
    return _arrays.integer("comm", comm, "i4")


def path_of(path: Path) -> bytes:
    """A path as C takes it, which would end it at a zero byte without a word."""
    text = os.fsencode(path)
    if b"\0" in text:
        raise ValueError(f"path {path!r}: has a zero byte")
    return text


class Kept:
    """A state of an engine in memory, made by Engine.keep(); freed with the object."""

    def __init__(self, pointer: c_void_p) -> None:
        self.pointer = pointer

    def __del__(self) -> None:
        lib.talus_kept_destroy(self.pointer)


class Engine(Setup, Grains, Observer):
    """One simulation.

    Engine(settings)                    from a Settings
    Engine(domain_lo=..., ...)          from the keywords of Settings
    Engine(settings, comm=MPI.COMM_WORLD)   over an mpi4py communicator [collective: same settings on every rank]
    Engine.load(path)                   from a checkpoint

    Use it in a `with` block, which closes it. It takes one caller at a time: a second thread gets a BusyError, but for
    request_stop(). Other threads of Python run while a call is under way, since ctypes releases the GIL.

    Raises ArgumentError, with a list of every fault, and UnsupportedError on a processor without AVX2 and FMA.
    """

    def __init__(self, settings: Optional[Settings] = None, comm: Any = None, **values: Any) -> None:
        struct = given(Settings, settings, values)
        pointer = c_void_p()
        if comm is None:
            status = lib.talus_engine_create(struct, pointer)
        else:
            status = lib.talus_engine_create_mpi(struct, handle_of(comm), pointer)
        self._adopt(status, pointer, comm)

    @classmethod
    def load(cls, path: Path, settings: Optional[Settings] = None, comm: Any = None, **values: Any) -> Engine:
        """Create an engine from a checkpoint, on any number of ranks. [collective]

        Physics comes from the file; of the settings only threads, skin, tile_grains, rebalance and rank_grid are used.
        Raises FileError if the file cannot be read or is damaged."""
        struct = given(Settings, settings, values)
        pointer = c_void_p()
        status = lib.talus_checkpoint_load(path_of(path), struct, SERIAL if comm is None else handle_of(comm), pointer)
        engine = cls.__new__(cls)
        engine._adopt(status, pointer, comm)
        return engine

    def _adopt(self, status: int, pointer: c_void_p, comm: Any) -> None:
        raise_for(status, lib.talus_message())
        self._stopped = False
        Setup.__init__(self, pointer, comm is not None)

    def __enter__(self) -> Engine:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def step(self, n_steps: int = 1) -> int:
        """Advance by whole steps; zero only prepares (checks, lists, first forces). [collective: same n_steps]

        Returns the steps done on all ranks, less than n_steps only if a stop was requested; `stopped` then is true.
        Raises ArgumentError (the engine is as before), or UnstableError, LostError, CommError, InternalError, FileError
        (the engine is poisoned); the exception's `done` tells the steps finished.

        Ctrl-C is seen when the call returns: take a million steps in calls of some thousand. A call costs next to
        nothing."""
        return self._advance(lib.talus_engine_step, _arrays.integer("n_steps", n_steps, "i8"))

    def advance_to(self, time: float) -> int:
        """Step until a time [s] is reached: the last step ends there or less than a step beyond it. [collective: same time]

        Returns and raises as step()."""
        return self._advance(lib.talus_engine_advance_to, _arrays.real("time", time))

    def _advance(self, function: Any, how_far: Any) -> int:
        done = c_int64()
        self._stopped = False
        try:
            status = self._call(function, how_far, done)
        except TalusError as error:
            error.done = done.value
            raise
        self._stopped = stopped(status)
        return done.value

    def keep(self) -> Kept:
        """The whole state, in memory, for restore(): implicit coupling tries a step more than once. [collective]"""
        pointer = c_void_p()
        self._call(lib.talus_engine_keep, pointer)
        return Kept(pointer)

    def restore(self, kept: Kept) -> None:
        """Go back to a state that this engine kept, as often as wanted; the same bits follow. [collective]"""
        self._call(lib.talus_engine_restore, kept.pointer)

    @property
    def stopped(self) -> bool:
        """Whether the last step() ended by request_stop(). [local]"""
        return self._stopped

    def save(self, path: Path) -> None:
        """Write a checkpoint, one HDF5 file, from which load() goes on with the same bits. [collective]"""
        self._call(lib.talus_checkpoint_save, path_of(path))

    def snapshot(self, path: Path) -> None:
        """Write a picture of the state for ParaView; the name must end with .hdf. [collective]"""
        self._call(lib.talus_snapshot_write, path_of(path))

    def trace(self, path: Path, steps: int) -> None:
        """Record the task graph's timeline of the next steps, in Chrome's trace format, written when they are done. [collective]"""
        self._call(lib.talus_trace_start, path_of(path), _arrays.integer("steps", steps, "i8"))

    def __repr__(self) -> str:
        return f"<talus.Engine, {'closed' if self.closed else 'open'}>"


def rank_grid(lengths: Any, ranks: int, periodic: Any = None, given: Any = None) -> tuple[int, int, int]:
    """The subdomains along x, y and z that a run on so many ranks has. [local]

    lengths  (3,) [m] of the grains, a periodic axis whole; periodic  (3,) 0 or 1, default all 0;
    given    (3,) subdomains along an axis where > 0, chosen where 0, default all chosen."""
    def three(name: str, value: Any) -> Any:
        return None if value is None else (ctypes.c_int32 * 3)(*_arrays.vector(name, value, 3, "i4"))

    out = (ctypes.c_int32 * 3)()
    status = lib.talus_rank_grid(_arrays.doubles("lengths", lengths), three("periodic", periodic), _arrays.integer("ranks", ranks, "i4"), three("given", given), out)
    raise_for(status, lib.talus_message())
    return (out[0], out[1], out[2])


def version() -> tuple[int, int, int]:
    """Major, minor and patch of the library in use. [local]"""
    number: int = lib.talus_version()
    return (number // 10000, number // 100 % 100, number % 100)


def build_info() -> str:
    """One line about the library's build. [local]"""
    text: bytes = lib.talus_build_info()
    return text.decode()


def status_string(status: int) -> str:
    """The header's name of a status, such as "TALUS_ERR_IO". [local]"""
    text: bytes = lib.talus_status_string(status)
    return text.decode()
