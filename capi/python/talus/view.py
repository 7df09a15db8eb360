"""Fields of the engine's grains seen where they lie, without a copy."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._arrays import Array
from ._constants import Field
from ._library import lib
from ._structs import ViewRecord
from .errors import BusyError, StaleView

if TYPE_CHECKING:
    from ._handle import Handle


class _Memory:
    """What numpy takes as the base of an array: it keeps the engine alive for as long as the array is."""

    def __init__(self, view: View) -> None:
        record = view._record
        three = record.components == 3
        self.engine = view._engine
        self.name = view.field.name.lower()
        self.generation: int = record.generation
        self.__array_interface__ = {
            "version": 3,
            "typestr": "<f8",
            "shape": (record.count, 3) if three else (record.count,),
            "strides": (record.stride, 8) if three else (record.stride,),
            "data": (ctypes.cast(record.data, ctypes.c_void_p).value or 0, True),  # True: read-only
        }


class View(np.lib.mixins.NDArrayOperatorsMixin):
    """A read-only look at POSITION, RADIUS, VELOCITY, ANGULAR_VELOCITY or MASS of this rank's grains, in slot order.

    Made by Engine.view(). Works wherever an array does: `numpy.linalg.norm(view, axis=1)`, `view[:, 1].max()`,
    `view * 2`. Each use asks the engine whether it has moved on since, and then raises StaleView. `array` is the bare
    numpy array; it cannot check, so use it at once and do not keep it.
    """

    def __init__(self, engine: Handle, field: Field) -> None:
        self._engine = engine
        self.field = field  #: which field it shows
        self._record = ViewRecord()
        engine._call(lib.talus_particles_view, int(field), self._record)

    @property
    def generation(self) -> int:
        """The engine's generation when the view was taken."""
        return int(self._record.generation)

    @property
    def stale(self) -> bool:
        """Whether the engine has moved on (or is closed), so that the view shows nothing any more."""
        return self._engine.closed or self._engine._generation() != self.generation

    @property
    def array(self) -> Array:
        """The numpy array, shape (n, 3) or (n,), strided and read-only, sharing the engine's memory."""
        if self._engine.closed:
            raise StaleView(f"view({self.field.name.lower()!r}): the engine is closed")
        now = self._engine._generation()
        if now != self.generation:
            raise StaleView(
                f"view({self.field.name.lower()!r}) was taken at generation {self.generation}, the engine is at {now}: "
                "it has stepped or grains were changed since. Take the view anew, or keep a copy")
        memory = _Memory(self)
        self._engine._exported.add(memory)
        return np.asarray(memory)

    @property
    def shape(self) -> tuple[int, ...]:
        """(n, 3) or (n,); known of a stale view too."""
        return (self._record.count, 3) if self._record.components == 3 else (self._record.count,)

    @property
    def dtype(self) -> np.dtype[Any]:
        """float64."""
        return np.dtype("f8")

    def __len__(self) -> int:
        return int(self._record.count)

    def __getitem__(self, index: Any) -> Any:
        # A copy, so that a slice that is kept cannot go stale unseen.
        return np.array(self.array[index])

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> Array:
        array = self.array
        if dtype is not None and np.dtype(dtype) != array.dtype:
            return array.astype(dtype)
        return array.copy() if copy else array

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **keywords: Any) -> Any:
        plain = [value.array if isinstance(value, View) else value for value in inputs]
        return getattr(ufunc, method)(*plain, **keywords)

    def __repr__(self) -> str:
        try:
            state = "stale" if self.stale else f"generation {self.generation}"
        except BusyError:  # a debugger's thread may well ask
            state = "the engine is busy"
        return f"<talus.View of {self.field.name.lower()}, shape {self.shape}, {state}>"
