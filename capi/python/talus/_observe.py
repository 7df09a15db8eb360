"""The part of Engine that looks: state, energy, stress, ranks, phases."""

from __future__ import annotations

import ctypes
from ctypes import c_double, c_int32, c_int64
from typing import Any, NamedTuple, Union

import numpy as np

from . import _arrays, _constants
from ._arrays import Array
from ._constants import CONTACT_FIELDS, ContactField
from ._handle import Handle
from ._library import lib
from ._structs import Energy, Memory, Phase, Rank, State
from .errors import ArgumentError


class Stress(NamedTuple):
    """Mean stress of a box."""

    tensor: Array  #: (3, 3) [Pa], compression negative
    solid_fraction: float  #: [1] volume of grains with their centre in the box / volume of the box
    coordination: float  #: [1] mean contacts of grains with their centre in the box


class InternalForce(NamedTuple):
    """Sum of the forces of grains on grains."""

    sum: Array  #: (3,) whole numbers of the unit: always 0 0 0
    unit: float  #: [N]


class Observer(Handle):
    """What can be observed. Every method is collective unless said."""

    def state(self) -> State:
        """Counts, sums and the digest of the whole engine, agreed over ranks. Costs about a force evaluation."""
        state = State()
        self._call(lib.talus_engine_state, state)
        return state

    def energy(self) -> Energy:
        """Energies now [J]: order-free sums, the same bits on any ranks."""
        energy = Energy()
        self._call(lib.talus_engine_energy, energy)
        return energy

    def stress(self, lo: Any, hi: Any) -> Stress:
        """Mean stress over the box from lo to hi [m], shape (3,) each (Love-Weber), with solid fraction and coordination."""
        tensor = (c_double * 9)()
        fraction, coordination = c_double(), c_double()
        self._call(lib.talus_engine_stress, _arrays.doubles("lo", lo), _arrays.doubles("hi", hi), tensor, fraction, coordination)
        return Stress(np.array(tensor).reshape(3, 3), fraction.value, coordination.value)

    def internal_force_sum(self) -> InternalForce:
        """The sum of all forces of grains on grains in the last evaluation, which Talus keeps at exactly zero."""
        total, unit = (c_int64 * 3)(), c_double()
        self._call(lib.talus_engine_internal_force_sum, total, unit)
        return InternalForce(np.array(total), unit.value)

    def ranks(self) -> list[Rank]:
        """What each rank holds, sends and takes; the same list on every rank."""
        return self._records(lib.talus_engine_ranks, Rank, self.size)

    def phases(self) -> list[Phase]:
        """Busy time of each phase since creation."""
        return self._records(lib.talus_engine_phases, Phase, 32)

    def contacts(self, field: Union[ContactField, int, str]) -> Array:
        """A field of the contacts whose grain i (the one with the smaller label) this rank holds, ordered by i, then j: labels
        (n, 2) int64, force on i [N], unit normal from j to i, point [m], all (n, 3), overlap (n,) [m], or sliding (n,) int32.
        j of a contact with a wall is WALL_LABEL plus its id."""
        wanted = ContactField(_constants.choose(ContactField, field, "field"))
        dtype, components = CONTACT_FIELDS[wanted]
        count = c_int64()
        self._call(lib.talus_contacts_copy, int(wanted), 0, None, count)
        # A rank with no contacts must still give room, since a capacity of zero only asks.
        array: Array = np.empty((count.value + 1,) if components == 1 else (count.value + 1, components), dtype)
        self._call(lib.talus_contacts_copy, int(wanted), len(array), array.ctypes.data, count)
        return array[: count.value]

    def memory(self) -> Memory:
        """Bytes that this rank's engine holds now, by category. [local]"""
        memory = Memory()
        self._call(lib.talus_engine_memory, memory)
        return memory

    @property
    def rank(self) -> int:
        """This rank. [local]"""
        return self._rank()[0]

    @property
    def size(self) -> int:
        """Ranks of the engine. [local]"""
        return self._rank()[1]

    @property
    def generation(self) -> int:
        """Changes whenever views become stale. [local]"""
        return self._generation()

    def _rank(self) -> tuple[int, int]:
        rank, ranks = c_int32(), c_int32()
        self._call(lib.talus_engine_rank, rank, ranks)
        return rank.value, ranks.value

    def _records(self, function: Any, kind: Any, capacity: int) -> list[Any]:
        """An array of structs, whose first one tells the library how far apart they stand."""
        while True:
            room = (kind * capacity)(kind())
            count = c_int32(capacity)
            try:
                self._call(function, count, room)
                return list(room[: count.value])
            except ArgumentError:
                if count.value <= capacity:
                    raise
                capacity = count.value
