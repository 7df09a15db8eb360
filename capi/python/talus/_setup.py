"""The part of Engine that sets up materials, contacts, walls, laws and time steps."""

from __future__ import annotations

import ctypes
from typing import Any, Optional

from . import _arrays
from ._handle import Handle
from ._library import lib
from ._struct import given
from ._structs import Contact, Laws, Material, Wall, WallState


class Setup(Handle):
    """Materials, contacts, walls, laws. Every method is collective, with the same arguments on every rank."""

    def add_material(self, material: Optional[Material] = None, **values: Any) -> int:
        """Add a material before the first step: a Material or its keywords (young [Pa], poisson, density [kg/m^3], rigid).

        Returns its id: 0, 1, 2 ... at most 16 of them."""
        return self._added(lib.talus_material_add, given(Material, material, values))

    def set_contact(self, material_a: int, material_b: int, contact: Optional[Contact] = None, **values: Any) -> None:
        """Set what two materials do in touch: a Contact or its keywords (restitution, friction, rolling_friction).

        Every pair that can meet must be set before the first step; may be called again between steps."""
        pair = (_arrays.integer("material_a", material_a, "i4"), _arrays.integer("material_b", material_b, "i4"))
        self._call(lib.talus_contact_set, *pair, given(Contact, contact, values))

    def add_wall(self, wall: Optional[Wall] = None, **values: Any) -> int:
        """Add an unbounded plane before the first step: a Wall or its keywords (material, point [m], normal towards the
        grains, velocity [m/s]). Returns its id: 0, 1, 2 ... at most 32 of them."""
        return self._added(lib.talus_wall_add, given(Wall, wall, values))

    def set_wall_velocity(self, wall: int, velocity: Any) -> None:
        """Move a wall at a velocity [m/s], shape (3,), from the next step on."""
        self._call(lib.talus_wall_set_velocity, _arrays.integer("wall", wall, "i4"), _arrays.doubles("velocity", velocity))

    def wall(self, wall: int) -> WallState:
        """Place, velocity, force, torque, contacts and work of a wall; the same on every rank."""
        state = WallState()
        self._call(lib.talus_wall_get, _arrays.integer("wall", wall, "i4"), state)
        return state

    def set_laws(self, laws: Optional[Laws] = None, **values: Any) -> None:
        """Change the contact laws between steps: a Laws or its keywords (over the defaults, not over the present laws).

        If the tangential or rolling law changes, all contact histories start anew from zero."""
        self._call(lib.talus_engine_set_laws, given(Laws, laws, values))

    def set_time_step(self, time_step: float) -> None:
        """Change the time step [s] between steps; checked at the next step."""
        self._call(lib.talus_engine_set_time_step, _arrays.real("time_step", time_step))

    def set_gravity(self, gravity: Any) -> None:
        """Change gravity [m/s^2], shape (3,), between steps."""
        self._call(lib.talus_engine_set_gravity, _arrays.doubles("gravity", gravity))

    def critical_step(self) -> float:
        """The Rayleigh step [s] of the present grains, smallest over them; infinity without grains."""
        step = ctypes.c_double()
        self._call(lib.talus_engine_critical_step, step)
        return step.value

    def _added(self, function: Any, struct: Any) -> int:
        number = ctypes.c_int32()
        self._call(function, struct, number)
        return number.value
