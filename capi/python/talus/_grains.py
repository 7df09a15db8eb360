"""The part of Engine that puts grains in, changes and removes them, and reads their fields."""

from __future__ import annotations

import ctypes
from ctypes import c_double, c_int32, c_int64
from typing import Any, Optional, Union

import numpy as np

from . import _arrays, _constants
from ._arrays import Array, pointer
from ._constants import FIELDS, Field, Group
from ._handle import Handle
from ._library import lib
from ._struct import given
from ._structs import Fill, Particles
from .view import View

FieldName = Union[Field, int, str]
AXES = {"x": 0, "y": 1, "z": 2}


def field_of(field: FieldName) -> Field:
    """A field by member, number or name."""
    number = _constants.choose(Field, field, "field")
    if number not in FIELDS:
        raise ValueError(f"field = {number}: takes one of {', '.join(f.name.lower() for f in Field)}")
    return Field(number)


def axis_of(axis: Union[int, str]) -> int:
    """0, 1, 2 or "x", "y", "z"."""
    if isinstance(axis, str):
        if axis.lower() not in AXES:
            raise ValueError(f"axis = {axis!r}: takes x, y or z")
        return AXES[axis.lower()]
    return _arrays.integer("axis", axis, "i4")


class Grains(Handle):
    """Grains in, grains out."""

    def insert(self, label: Any, position: Any, radius: Any, velocity: Any = None, angular_velocity: Any = None,
               material: Any = None, group: Any = None, colour: Any = None, *, max_overlap: float = 0.05) -> None:
        """Insert n grains; any rank may give any of them. [collective: own grains on each rank, also none]

        label             (n,) whole numbers >= 0, unique over all ranks and for ever; it tells n
        position          (n, 3) [m], within the domain
        radius            (n,) [m], or one number for all
        velocity          (n, 3) [m/s], or (3,) for all; default zero
        angular_velocity  (n, 3) [rad/s], or (3,) for all; default zero
        material, group, colour   (n,) whole numbers, or one for all; default 0
        max_overlap       [1] of the smaller radius

        Arrays of another layout or width are copied; nothing is kept. All faults are checked before any change
        (ArgumentError). A wrong type or shape is a TypeError or ValueError on the rank that has it and an ArgumentError on
        the others, so that none of them waits."""
        try:
            overlap = _arrays.real("max_overlap", max_overlap)
            struct, arrays = packed(label, position, radius, velocity, angular_velocity, material, group, colour)
        except Exception:
            if self._box.parallel:
                self._refuse_insert()
            raise
        self._call(lib.talus_particles_insert, struct, overlap)
        del arrays  # kept until here: the struct only points at them

    def _refuse_insert(self) -> None:
        """Take part in the collective call with a count that the library refuses on all ranks."""
        try:
            self._call(lib.talus_particles_insert, Particles(count=-1), 0.0)
        except Exception:
            pass  # the caller has the true reason at hand

    def fill(self, fill: Optional[Fill] = None, **values: Any) -> int:
        """Fill a box at random without overlaps: a Fill or its keywords (material, lo, hi, radius_min, radius_max [m], count,
        first_label, jitter, room, group). Returns the number of grains placed over all ranks. [collective]"""
        count = c_int64()
        self._call(lib.talus_particles_fill, given(Fill, fill, values), count)
        return count.value

    def set_group(self, group: int, mode: Union[Group, int, str], velocity: Any = None, angular_velocity: Any = None) -> None:
        """Set how a group of grains moves: free, frozen, or driven at velocity [m/s] and angular_velocity [rad/s], shape (3,)
        each, default zero. [collective]"""
        motions = [None if v is None else _arrays.doubles(n, v) for n, v in (("velocity", velocity), ("angular_velocity", angular_velocity))]
        self._call(lib.talus_group_set, _arrays.integer("group", group, "i4"), _constants.choose(Group, mode, "mode"), *motions)

    def add_velocity(self, velocity: Any) -> None:
        """Add one velocity [m/s], shape (3,), to every free grain. [collective]"""
        self._call(lib.talus_particles_add_velocity, _arrays.doubles("velocity", velocity))

    def stop_grains(self) -> None:
        """Set velocity and spin of every free grain to zero. [collective]"""
        self._call(lib.talus_particles_stop)

    def colour_layers(self, axis: Union[int, str], origin: float, thickness: float) -> None:
        """Colour by layers of equal thickness [m] along an axis: floor((x - origin) / thickness) mod 256. [collective]"""
        self._call(lib.talus_particles_colour_layers, axis_of(axis), _arrays.real("origin", origin), _arrays.real("thickness", thickness))

    def remove_above(self, axis: Union[int, str], level: float) -> int:
        """Remove the grains with their centre above a level [m] along an axis. Returns how many, over all ranks. [collective]"""
        removed = c_int64()
        self._call(lib.talus_particles_remove_above, axis_of(axis), _arrays.real("level", level), removed)
        return removed.value

    def remove_box(self, lo: Any, hi: Any) -> int:
        """Remove the grains with their centre in the box lo <= x < hi [m]. Returns how many, over all ranks. [collective]"""
        removed = c_int64()
        self._call(lib.talus_particles_remove_box, _arrays.doubles("lo", lo), _arrays.doubles("hi", hi), removed)
        return removed.value

    def remove(self, labels: Any) -> int:
        """Remove grains by label, whichever rank holds them. Returns how many, over all ranks.

        Raises ArgumentError, and removes none, if there is no grain of a label. [collective: own labels on each rank]"""
        wanted = np.atleast_1d(_arrays.converted("labels", labels, "i8"))
        if wanted.ndim != 1:
            raise ValueError(f"labels: takes shape (n,), was given {wanted.shape}")
        removed = c_int64()
        self._call(lib.talus_particles_remove, len(wanted), pointer(wanted, c_int64), removed)
        return removed.value

    def mark_reference(self) -> None:
        """Take the present positions as the origin of the displacement field. [collective]"""
        self._call(lib.talus_particles_mark_reference)

    def view(self, field: FieldName) -> View:
        """Look at position, radius, velocity, angular_velocity or mass of this rank's grains without a copy, in slot
        order (which no two runs need share). Stale as soon as the engine moves on. [local]"""
        return View(self, field_of(field))

    def copy(self, field: FieldName) -> Array:
        """A field of this rank's grains ordered by label: a new array of shape (n,) or (n, 3), float64, int64 (label) or
        int32 (material, group, colour, owner). [local]"""
        return self._read(lib.talus_particles_copy, field_of(field), len(self.view(Field.RADIUS)))

    def gather(self, field: FieldName) -> Array:
        """A field of all grains ordered by label on rank 0, of no grain on the other ranks; shapes as copy(). [collective]"""
        wanted = field_of(field)
        total = sum(rank.particles for rank in self.ranks())  # type: ignore[attr-defined]
        return self._read(lib.talus_particles_gather, wanted, total)

    def _read(self, function: Any, field: Field, capacity: int) -> Array:
        dtype, components = FIELDS[field]
        array: Array = np.empty((capacity,) if components == 1 else (capacity, components), dtype)
        count = c_int64()
        self._call(function, int(field), capacity, array.ctypes.data, count)
        return array if count.value == capacity else array[: count.value].copy()


def packed(label: Any, position: Any, radius: Any, velocity: Any, angular_velocity: Any, material: Any, group: Any, colour: Any) -> tuple[Particles, list[Any]]:
    """The struct that points at the caller's arrays, and the arrays that it points at."""
    labels = np.atleast_1d(_arrays.converted("label", label, "i8"))
    if labels.ndim != 1:
        raise ValueError(f"label: takes shape (n,), was given {labels.shape}")
    n = len(labels)
    positions = _arrays.converted("position", position, "f8")
    if positions.shape != (n, 3) and not (n == 1 and positions.shape == (3,)) and not (n == 0 and positions.size == 0):
        raise ValueError(f"position: takes shape ({n}, 3), as there are {n} labels, was given {positions.shape}")
    rows = _arrays.rows
    arrays = {
        "label": labels,
        "position": positions,
        "radius": rows("radius", radius, n, 1, "f8"),
        "velocity": rows("velocity", velocity, n, 3, "f8"),
        "angular_velocity": rows("angular_velocity", angular_velocity, n, 3, "f8"),
        "material": rows("material", material, n, 1, "i4"),
        "group": rows("group", group, n, 1, "i4"),
        "colour": rows("colour", colour, n, 1, "i4"),
    }
    if arrays["radius"] is None:
        raise TypeError("radius: takes numbers, was given None")
    kinds: dict[str, type[ctypes._SimpleCData[Any]]] = {"label": c_int64, "material": c_int32, "group": c_int32, "colour": c_int32}
    struct = Particles(count=n)
    for name, array in arrays.items():
        setattr(struct, name, pointer(array, kinds.get(name, c_double)))
    return struct, list(arrays.values())
