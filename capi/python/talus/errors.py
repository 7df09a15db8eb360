"""Exceptions: one class for each status that tells of a failure, carrying the library's own text."""

from __future__ import annotations

from typing import Optional

from ._constants import Status


class TalusError(Exception):
    """Any failure that Talus reports."""

    status: Optional[Status] = None  #: what the library returned; None if the binding itself refused
    done: Optional[int] = None  #: steps finished on all ranks before a step call failed; None elsewhere


class ArgumentError(TalusError, ValueError):
    """An argument is wrong; the engine is as it was before."""

    status = Status.ERR_ARGUMENT


class StateError(TalusError, RuntimeError):
    """The call does not fit the engine's state: too late, too early, or the engine is poisoned by an earlier failure."""

    status = Status.ERR_STATE


class UnstableError(TalusError, ArithmeticError):
    """The simulation left its valid range. The engine is poisoned: only counts, messages and close() still work."""

    status = Status.ERR_UNSTABLE


class LostError(TalusError, ArithmeticError):
    """A grain left the domain. The engine is poisoned."""

    status = Status.ERR_LOST


class FileError(TalusError, OSError):
    """A file could not be read or written, or is damaged."""

    status = Status.ERR_IO


class CommError(TalusError, RuntimeError):
    """MPI failed. The engine is poisoned, and ranks may no longer agree."""

    status = Status.ERR_COMM


class CapacityError(TalusError, MemoryError):
    """Out of memory, or of an index range."""

    status = Status.ERR_CAPACITY


class UnsupportedError(TalusError, NotImplementedError):
    """This machine or this build of the library cannot do it."""

    status = Status.ERR_UNSUPPORTED


class InternalError(TalusError, RuntimeError):
    """A defect of the library: please report it."""

    status = Status.ERR_INTERNAL


class ClosedError(TalusError, RuntimeError):
    """The engine was closed."""


class BusyError(TalusError, RuntimeError):
    """Another thread is inside a call on the same engine."""


class StaleView(TalusError, RuntimeError):
    """The engine has moved on since a view was taken; take it anew."""


class StaleArrayWarning(UserWarning):
    """A bare array of a view is still held after the engine moved on: it shows wrong or freed memory."""


BY_STATUS: dict[int, type[TalusError]] = {
    int(c.status): c
    for c in (ArgumentError, StateError, UnstableError, LostError, FileError, CommError, CapacityError, UnsupportedError, InternalError)
    if c.status is not None
}


def failure(status: int, text: str) -> TalusError:
    """The exception of a status. A status that this binding does not know (of a newer library) is a TalusError."""
    return BY_STATUS.get(status, TalusError)(text or f"the library returned status {status} without a text")
