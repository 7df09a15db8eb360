"""The functions of talus.h. To add one: a line in STATUS_FUNCTIONS (or OTHER_FUNCTIONS, if it returns no status)."""

from __future__ import annotations

from ctypes import POINTER, c_char_p, c_double, c_int32, c_int64, c_size_t, c_uint64, c_void_p
from typing import Any

from . import _structs as s
from ._library import lib

engine = c_void_p  # the opaque handle
doubles = POINTER(c_double)
out_engine = POINTER(engine)
kept = c_void_p  # the opaque state in memory
out_int32, out_int64, out_uint64 = POINTER(c_int32), POINTER(c_int64), POINTER(c_uint64)


def to(struct: Any) -> Any:
    """Pointer to a struct."""
    return POINTER(struct)


#: arguments of the functions that return a talus_status
STATUS_FUNCTIONS: dict[str, list[Any]] = {
    # settings
    "talus_laws_init": [to(s.Laws)],
    "talus_settings_init": [to(s.Settings)],
    "talus_settings_init_sized": [to(s.Settings), c_size_t],
    # life cycle
    "talus_engine_create": [to(s.Settings), out_engine],
    "talus_engine_create_mpi": [to(s.Settings), c_int32, out_engine],
    "talus_engine_rank": [engine, out_int32, out_int32],
    "talus_rank_grid": [doubles, out_int32, c_int32, out_int32, out_int32],
    "talus_engine_set_laws": [engine, to(s.Laws)],
    "talus_engine_set_time_step": [engine, c_double],
    "talus_engine_set_gravity": [engine, doubles],
    "talus_engine_critical_step": [engine, doubles],
    # materials
    "talus_material_init": [to(s.Material)],
    "talus_contact_init": [to(s.Contact)],
    "talus_material_add": [engine, to(s.Material), out_int32],
    "talus_contact_set": [engine, c_int32, c_int32, to(s.Contact)],
    # walls
    "talus_wall_init": [to(s.Wall)],
    "talus_wall_state_init": [to(s.WallState)],
    "talus_wall_add": [engine, to(s.Wall), out_int32],
    "talus_wall_set_velocity": [engine, c_int32, doubles],
    "talus_wall_get": [engine, c_int32, to(s.WallState)],
    # particles
    "talus_particles_init": [to(s.Particles)],
    "talus_particles_insert": [engine, to(s.Particles), c_double],
    "talus_fill_init": [to(s.Fill)],
    "talus_particles_fill": [engine, to(s.Fill), out_int64],
    "talus_group_set": [engine, c_int32, c_int32, doubles, doubles],
    "talus_particles_add_velocity": [engine, doubles],
    "talus_particles_stop": [engine],
    "talus_particles_colour_layers": [engine, c_int32, c_double, c_double],
    "talus_particles_remove_above": [engine, c_int32, c_double, out_int64],
    "talus_particles_remove_box": [engine, doubles, doubles, out_int64],
    "talus_particles_remove": [engine, c_int64, out_int64, out_int64],
    "talus_particles_mark_reference": [engine],
    # stepping
    "talus_engine_step": [engine, c_int64, out_int64],
    "talus_engine_advance_to": [engine, c_double, out_int64],
    # observing
    "talus_state_init": [to(s.State)],
    "talus_state_init_sized": [to(s.State), c_size_t],
    "talus_engine_state": [engine, to(s.State)],
    "talus_rank_init": [to(s.Rank)],
    "talus_engine_ranks": [engine, out_int32, to(s.Rank)],
    "talus_energy_init": [to(s.Energy)],
    "talus_engine_energy": [engine, to(s.Energy)],
    "talus_engine_stress": [engine, doubles, doubles, doubles, doubles, doubles],
    "talus_engine_internal_force_sum": [engine, out_int64, doubles],
    "talus_particles_copy": [engine, c_int32, c_int64, c_void_p, out_int64],
    "talus_particles_gather": [engine, c_int32, c_int64, c_void_p, out_int64],
    "talus_contacts_copy": [engine, c_int32, c_int64, c_void_p, out_int64],
    "talus_view_init": [to(s.ViewRecord)],
    "talus_particles_view": [engine, c_int32, to(s.ViewRecord)],
    "talus_engine_generation": [engine, out_uint64],
    "talus_phase_init": [to(s.Phase)],
    "talus_engine_phases": [engine, out_int32, to(s.Phase)],
    "talus_memory_init": [to(s.Memory)],
    "talus_engine_memory": [engine, to(s.Memory)],
    # files
    "talus_checkpoint_save": [engine, c_char_p],
    "talus_checkpoint_load": [c_char_p, to(s.Settings), c_int32, out_engine],
    "talus_engine_keep": [engine, POINTER(kept)],
    "talus_engine_restore": [engine, kept],
    "talus_snapshot_write": [engine, c_char_p],
    "talus_trace_start": [engine, c_char_p, c_int64],
}

#: result and arguments of the others
OTHER_FUNCTIONS: dict[str, tuple[Any, list[Any]]] = {
    "talus_status_string": (c_char_p, [c_int32]),
    "talus_message": (c_char_p, []),
    "talus_version": (c_int32, []),
    "talus_build_info": (c_char_p, []),
    "talus_engine_destroy": (None, [engine]),
    "talus_kept_destroy": (None, [kept]),
    "talus_engine_message": (c_char_p, [engine]),
    "talus_engine_request_stop": (None, [engine]),
}

#: result and arguments of every function of the header that is bound
PROTOTYPES: dict[str, tuple[Any, list[Any]]] = {name: (c_int32, arguments) for name, arguments in STATUS_FUNCTIONS.items()} | OTHER_FUNCTIONS


def bind() -> None:
    """Give every function its prototype; a library without one of them is older than this package."""
    for name, (result, arguments) in PROTOTYPES.items():
        try:
            function = getattr(lib, name)
        except AttributeError:
            raise ImportError(f"{lib._name} has no {name}: it is older than this Python package") from None
        function.restype, function.argtypes = result, arguments


bind()
