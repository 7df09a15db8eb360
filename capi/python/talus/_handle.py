"""The life of one engine's handle, and the one way in which its functions are called."""

from __future__ import annotations

import contextlib
import ctypes
import threading
import warnings
import weakref
from collections.abc import Iterator
from typing import Any, Optional

from . import _functions  # noqa: F401  (binds the prototypes)
from ._constants import Status
from ._library import lib
from .errors import BusyError, ClosedError, StaleArrayWarning, failure


class _Box:
    """The C pointer, outside of the engine so that it can be destroyed when the engine is gone already."""

    def __init__(self, pointer: ctypes.c_void_p, parallel: bool) -> None:
        self.pointer: Optional[ctypes.c_void_p] = pointer
        self.parallel = parallel
        self.lock = threading.RLock()  # held to destroy and to request a stop, which may come from another thread

    def destroy(self) -> None:
        with self.lock:
            pointer, self.pointer = self.pointer, None
            if pointer is not None:
                lib.talus_engine_destroy(pointer)

    def forgotten(self) -> None:
        """Collected without close(). Destroying a parallel engine is collective, and no two ranks collect their
        garbage at the same moment: rather than wait for each other at random, they keep the memory."""
        if self.pointer is None:
            return
        if self.parallel:
            warnings.warn("a parallel talus.Engine was not closed: its memory stays until the process ends", ResourceWarning, stacklevel=2)
        else:
            self.destroy()


def raise_for(status: int, text: Optional[bytes]) -> None:
    """Turn a failure into its exception."""
    if status < 0:
        raise failure(status, (text or b"").decode(errors="replace"))


class Handle:
    """Owns the C handle. Everything that an engine does goes through _call()."""

    def __init__(self, pointer: ctypes.c_void_p, parallel: bool) -> None:
        self._box = _Box(pointer, parallel)
        self._busy = threading.Lock()
        self._exported: weakref.WeakSet[Any] = weakref.WeakSet()  # memory that numpy arrays of views show
        weakref.finalize(self, self._box.forgotten)

    def _pointer(self) -> ctypes.c_void_p:
        pointer = self._box.pointer
        if pointer is None:
            raise ClosedError("the engine is closed")
        return pointer

    @contextlib.contextmanager
    def _alone(self) -> Iterator[ctypes.c_void_p]:
        """The pointer, for as long as no other thread is inside of a call on this engine."""
        if not self._busy.acquire(blocking=False):
            raise BusyError("another thread is inside a call on this engine; one engine takes one caller at a time")
        try:
            yield self._pointer()
        finally:
            self._busy.release()

    def _call(self, function: Any, *arguments: Any) -> int:
        """Call function(engine, *arguments), raise its failure, return its status (OK or STOPPED)."""
        with self._alone() as pointer:
            status: int = function(pointer, *arguments)
            text = lib.talus_engine_message(pointer) if status < 0 else None
            if self._exported:
                now = ctypes.c_uint64()
                lib.talus_engine_generation(pointer, now)
                self._warn_of_stale_arrays(now.value, 4)
        raise_for(status, text)
        return status

    def _generation(self) -> int:
        """Changes whenever views become stale."""
        number = ctypes.c_uint64()
        self._call(lib.talus_engine_generation, number)
        return number.value

    def _warn_of_stale_arrays(self, generation: Optional[int], stacklevel: int) -> None:
        """Tell once of arrays that someone still holds and that are not of this generation (None: of any)."""
        stale = [memory for memory in self._exported if memory.generation != generation]
        for memory in stale:
            self._exported.discard(memory)
        if stale:
            warnings.warn(
                f"an array of view({stale[0].name!r}) is still held after the engine moved on; it may show freed memory. "
                "Keep the View, which checks, or a copy", StaleArrayWarning, stacklevel=stacklevel)

    @property
    def closed(self) -> bool:
        """Whether close() was called."""
        return self._box.pointer is None

    def close(self) -> None:
        """Free everything; again is fine, and so is after an error. [collective for a healthy parallel engine, else local]

        Called at the end of a `with` block. A serial engine is also freed when nothing refers to it any more."""
        if self.closed:
            return
        with self._alone():
            self._warn_of_stale_arrays(None, 3)
            self._box.destroy()

    def request_stop(self) -> None:
        """Ask the running or the next step() to end after its current step, on every rank. [local]

        May be called from another thread while step() runs, which is what it is for. It cannot be called by Python's
        handler of a signal in the thread that steps: Python runs handlers only when the call has returned."""
        with self._box.lock:
            lib.talus_engine_request_stop(self._pointer())

    @property
    def message(self) -> str:
        """The text of the last failure; empty if the last call went well. [local]"""
        with self._alone() as pointer:
            text: bytes = lib.talus_engine_message(pointer)
        return text.decode(errors="replace")


def stopped(status: int) -> bool:
    """Whether a step call ended by request."""
    return status == Status.STOPPED
