"""The constants of talus.h as enumerations. To add one: a member here, or a class and its prefix in ENUMERATIONS."""

from __future__ import annotations

import enum

from . import _library


class Status(enum.IntEnum):
    """What a function of the library returns."""

    OK = 0
    STOPPED = 1
    ERR_ARGUMENT = -1
    ERR_STATE = -2
    ERR_UNSTABLE = -3
    ERR_LOST = -4
    ERR_IO = -5
    ERR_COMM = -6
    ERR_CAPACITY = -7
    ERR_UNSUPPORTED = -8
    ERR_INTERNAL = -9


class Normal(enum.IntEnum):
    """Normal contact law."""

    HERTZ = 0
    LINEAR = 1


class Damping(enum.IntEnum):
    """CLIPPED never attracts and gives the restitution asked for; ATTRACTIVE is what LAMMPS and LIGGGHTS do."""

    CLIPPED = 0
    ATTRACTIVE = 1


class Tangential(enum.IntEnum):
    """Tangential contact law."""

    FORCE_RESCALED = 0
    FORCE = 1
    DISPLACEMENT = 2
    NONE = 3


class Rolling(enum.IntEnum):
    """Rolling resistance: none, type A (constant directional torque), type C (spring and dashpot)."""

    NONE = 0
    CONSTANT = 1
    SPRING = 2


class RollingRadius(enum.IntEnum):
    """Radius in the rolling torque."""

    EFFECTIVE = 0
    OWN = 1


class Rebalance(enum.IntEnum):
    """When subdomains are cut anew."""

    OFF = 0
    AUTO = 1
    EVERY = 2
    RANDOM = 3


class Group(enum.IntEnum):
    """How the grains of a group move."""

    FREE = 0
    FROZEN = 1
    DRIVEN = 2


class Field(enum.IntEnum):
    """A value that every grain has. See FIELDS for type and shape."""

    LABEL = 0
    POSITION = 1
    RADIUS = 2
    VELOCITY = 3
    ANGULAR_VELOCITY = 4
    FORCE = 5
    TORQUE = 6
    MASS = 7
    MATERIAL = 8
    GROUP = 9
    COLOUR = 10
    DISPLACEMENT = 11
    OWNER = 12


#: numpy type and components of each field
FIELDS: dict[Field, tuple[str, int]] = {
    Field.LABEL: ("i8", 1),
    Field.POSITION: ("f8", 3),
    Field.RADIUS: ("f8", 1),
    Field.VELOCITY: ("f8", 3),
    Field.ANGULAR_VELOCITY: ("f8", 3),
    Field.FORCE: ("f8", 3),
    Field.TORQUE: ("f8", 3),
    Field.MASS: ("f8", 1),
    Field.MATERIAL: ("i4", 1),
    Field.GROUP: ("i4", 1),
    Field.COLOUR: ("i4", 1),
    Field.DISPLACEMENT: ("f8", 3),
    Field.OWNER: ("i4", 1),
}

class ContactField(enum.IntEnum):
    """A value that every contact has. See CONTACT_FIELDS for type and shape."""

    LABELS = 0
    FORCE = 1
    NORMAL = 2
    POINT = 3
    OVERLAP = 4
    SLIDING = 5


#: numpy type and components of each field of contacts
CONTACT_FIELDS: dict[ContactField, tuple[str, int]] = {
    ContactField.LABELS: ("i8", 2),
    ContactField.FORCE: ("f8", 3),
    ContactField.NORMAL: ("f8", 3),
    ContactField.POINT: ("f8", 3),
    ContactField.OVERLAP: ("f8", 1),
    ContactField.SLIDING: ("i4", 1),
}

WALL_LABEL = 2**62  #: plus the id of a wall: the second label of its contacts
SERIAL = -(2**31)  #: stands for "no communicator" in talus_checkpoint_load

#: the prefix that the header puts before the members of each class
ENUMERATIONS: dict[str, type[enum.IntEnum]] = {
    "TALUS_": Status,
    "TALUS_NORMAL_": Normal,
    "TALUS_DAMPING_": Damping,
    "TALUS_TANGENTIAL_": Tangential,
    "TALUS_ROLLING_": Rolling,
    "TALUS_ROLLING_RADIUS_": RollingRadius,
    "TALUS_REBALANCE_": Rebalance,
    "TALUS_GROUP_": Group,
    "TALUS_FIELD_": Field,
    "TALUS_CONTACT_": ContactField,
}


def header_constants() -> dict[str, int]:
    """Every constant of talus.h that is bound, by its name there."""
    major, minor, patch = _library.VERSION
    found = {
        "TALUS_VERSION_MAJOR": major,
        "TALUS_VERSION_MINOR": minor,
        "TALUS_VERSION_PATCH": patch,
        "TALUS_VERSION_NUMBER": major * 10000 + minor * 100 + patch,
        "TALUS_SERIAL": SERIAL,
        "TALUS_WALL_LABEL": WALL_LABEL,
    }
    for prefix, enumeration in ENUMERATIONS.items():
        found.update((prefix + member.name, int(member)) for member in enumeration)
    return found


def choose(enumeration: type[enum.IntEnum], value: object, name: str) -> int:
    """A member given as itself, as its number, or as its name in any case ("hertz").

    A number that is no member is passed on: the library refuses it, together with all other faults."""
    if not isinstance(value, str):
        return int(value)  # type: ignore[call-overload]
    try:
        return int(enumeration[value.upper()])
    except KeyError:
        choices = ", ".join(member.name.lower() for member in enumeration)
        raise ValueError(f"{name} = {value!r}: takes one of {choices}") from None
