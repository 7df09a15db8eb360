"""The structs of talus.h, member by member. To add one: a class here, and its name in STRUCTS; what a member means, its
unit and its default are said in talus.h."""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_char, c_double, c_int32, c_int64, c_uint32, c_uint64

from ._constants import Damping, Normal, Rebalance, Rolling, RollingRadius, Tangential
from ._struct import Struct

vec3 = c_double * 3
int3 = c_int32 * 3


class Laws(Struct):
    """Contact laws: normal, damping, tangential, rolling, and their numbers."""

    C_NAME, INIT = "talus_laws", "talus_laws_init"
    CHOICES = {"normal": Normal, "damping": Damping, "tangential": Tangential, "rolling": Rolling, "rolling_radius": RollingRadius}
    _fields_ = [
        ("struct_size", c_uint32),
        ("normal", c_int32),
        ("damping", c_int32),
        ("tangential", c_int32),
        ("rolling", c_int32),
        ("rolling_radius", c_int32),
        ("tangential_damping", c_int32),
        ("reserved", c_int32),
        ("rolling_rate", c_double),
        ("rolling_damping", c_double),
        ("stiffness_n", c_double),
        ("stiffness_t", c_double),
    ]


class Settings(Struct):
    """All that an engine is created with. domain_lo, domain_hi [m] and time_step [s] have no default."""

    C_NAME, INIT = "talus_settings", "talus_settings_init_sized"
    CHOICES = {"rebalance": Rebalance}
    _fields_ = [
        ("struct_size", c_uint32),
        ("header_version", c_int32),
        ("domain_lo", vec3),
        ("domain_hi", vec3),
        ("periodic", int3),
        ("threads", c_int32),
        ("gravity", vec3),
        ("time_step", c_double),
        ("time_step_limit", c_double),
        ("skin", c_double),
        ("radius_max", c_double),
        ("tile_grains", c_int32),
        ("rebalance", c_int32),
        ("rank_grid", int3),
        ("energy_ledger", c_int32),
        ("seed", c_uint64),
        ("laws", Laws),
        ("rebalance_interval", c_int32),
        ("reserved", c_int32),
    ]


class Material(Struct):
    """What grains or walls are made of: young [Pa], poisson [1], density [kg/m^3], or rigid=1 for a wall."""

    C_NAME, INIT = "talus_material", "talus_material_init"
    _fields_ = [("struct_size", c_uint32), ("rigid", c_int32), ("young", c_double), ("poisson", c_double), ("density", c_double)]


class Contact(Struct):
    """What two materials do in touch: restitution, friction, rolling_friction, all [1]."""

    C_NAME, INIT = "talus_contact", "talus_contact_init"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_int32),
        ("restitution", c_double),
        ("friction", c_double),
        ("rolling_friction", c_double),
    ]


class Wall(Struct):
    """A plane: point [m], normal towards the grains, velocity [m/s], material id."""

    C_NAME, INIT = "talus_wall", "talus_wall_init"
    _fields_ = [("struct_size", c_uint32), ("material", c_int32), ("point", vec3), ("normal", vec3), ("velocity", vec3)]


class WallState(Struct):
    """A wall now: contacts, point [m], velocity [m/s], force [N] and torque [N m] of the grains on it, work [J]."""

    C_NAME, INIT = "talus_wall_state", "talus_wall_state_init"
    _fields_ = [
        ("struct_size", c_uint32),
        ("contacts", c_int32),
        ("point", vec3),
        ("velocity", vec3),
        ("force", vec3),
        ("torque", vec3),
        ("work", c_double),
    ]


class Particles(Struct):
    """Pointers to what insert() is given; Engine.insert() fills it from arrays."""

    C_NAME, INIT = "talus_particles", "talus_particles_init"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_int32),
        ("count", c_int64),
        ("label", POINTER(c_int64)),
        ("position", POINTER(c_double)),
        ("radius", POINTER(c_double)),
        ("velocity", POINTER(c_double)),
        ("angular_velocity", POINTER(c_double)),
        ("material", POINTER(c_int32)),
        ("group", POINTER(c_int32)),
        ("colour", POINTER(c_int32)),
    ]


class Fill(Struct):
    """A box [lo, hi] to fill at random with grains of radius_min to radius_max [m]."""

    C_NAME, INIT = "talus_fill", "talus_fill_init"
    _fields_ = [
        ("struct_size", c_uint32),
        ("material", c_int32),
        ("lo", vec3),
        ("hi", vec3),
        ("radius_min", c_double),
        ("radius_max", c_double),
        ("count", c_int64),
        ("first_label", c_int64),
        ("jitter", c_double),
        ("room", c_double),
        ("group", c_int32),
        ("reserved", c_int32),
    ]


class State(Struct):
    """Counts and sums of the whole engine; see talus.h for each."""

    C_NAME, INIT = "talus_state", "talus_state_init_sized"
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_int32),
        ("threads_observed", c_int32),
        ("ranks", c_int32),
        ("step", c_int64),
        ("time", c_double),
        ("particles", c_int64),
        ("local_particles", c_int64),
        ("ghosts", c_int64),
        ("contacts", c_int64),
        ("wall_contacts", c_int64),
        ("sliding_contacts", c_int64),
        ("rebuilds", c_int64),
        ("rebalances", c_int64),
        ("migrations", c_int64),
        ("imbalance", c_double),
        ("skin", c_double),
        ("bytes_per_particle", c_double),
        ("kinetic_energy", c_double),
        ("max_speed", c_double),
        ("unbalanced_force", c_double),
        ("max_overlap", c_double),
        ("digest_lo", c_uint64),
        ("digest_hi", c_uint64),
        ("halo_messages", c_int64),
        ("halo_bytes", c_int64),
    ]

    @property
    def digest(self) -> str:
        """The 128-bit digest of the state as 32 hexadecimal digits, as talus-sandbox prints it."""
        return f"{self.digest_hi:016x}{self.digest_lo:016x}"


class Rank(Struct):
    """What one rank holds, sends and takes."""

    C_NAME, INIT = "talus_rank", "talus_rank_init"
    _fields_ = [
        ("struct_size", c_uint32),
        ("rank", c_int32),
        ("lo", vec3),
        ("hi", vec3),
        ("particles", c_int64),
        ("ghosts", c_int64),
        ("halo_messages", c_int64),
        ("halo_bytes", c_int64),
        ("tiles", c_int32),
        ("threads", c_int32),
        ("busy", c_double),
    ]


class Energy(Struct):
    """Energies [J]: kinetic, rotational, stored in contacts, gravity, work of walls, dissipated."""

    C_NAME, INIT = "talus_energy", "talus_energy_init"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_int32),
        ("kinetic", c_double),
        ("rotational", c_double),
        ("elastic_normal", c_double),
        ("elastic_tangential", c_double),
        ("elastic_rolling", c_double),
        ("gravity", c_double),
        ("wall_work", c_double),
        ("friction", c_double),
        ("damping", c_double),
        ("rolling", c_double),
    ]


class ViewRecord(Struct):
    """Where a field lies in the engine's memory; talus.View is what a user gets."""

    C_NAME, INIT = "talus_view", "talus_view_init"
    _fields_ = [
        ("struct_size", c_uint32),
        ("components", c_int32),
        ("count", c_int64),
        ("stride", c_int64),
        ("data", POINTER(c_double)),
        ("generation", c_uint64),
    ]


class Phase(Struct):
    """Busy time of one phase: name, min, mean and max over ranks [s], calls."""

    C_NAME, INIT = "talus_phase", "talus_phase_init"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_int32),
        ("name", c_char * 24),
        ("min", c_double),
        ("mean", c_double),
        ("max", c_double),
        ("calls", c_int64),
    ]


class Memory(Struct):
    """Bytes of one rank's engine by category: records, cells, sums, pairs, histories, rebuild."""

    C_NAME, INIT = "talus_memory", "talus_memory_init"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_int32),
        ("records", c_int64),
        ("cells", c_int64),
        ("sums", c_int64),
        ("pairs", c_int64),
        ("histories", c_int64),
        ("rebuild", c_int64),
    ]


#: every struct of the header that is bound, by its name there
STRUCTS: dict[str, type[ctypes.Structure]] = {
    struct.C_NAME: struct
    for struct in (Laws, Settings, Material, Contact, Wall, WallState, Particles, Fill, State, Rank, Energy, ViewRecord, Phase, Memory)
}
