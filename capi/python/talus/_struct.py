"""What all structs of talus.h have in common: defaults from the library, keywords, and refusal of names they lack."""

from __future__ import annotations

import ctypes
import difflib
import enum
from collections.abc import Mapping
from typing import Any, Optional

import numpy as np

from . import _arrays, _constants
from ._library import lib

HIDDEN = ("struct_size", "header_version", "reserved")  # not the user's business

# An _init function writes as much as its library knows, which in a newer one may be more than the struct here.
ROOM_FOR_INIT = 65536


class Struct(ctypes.Structure):
    """A struct of talus.h. Keywords set members; what is not given has the library's default.

    Members that are arrays read as numpy arrays that share the struct's memory; members that are one of several
    choices take the member of the enumeration, its number, or its name as text. A name that the struct does not have is an
    error that tells which names it has.
    """

    C_NAME: str  #: its name in talus.h
    INIT: Optional[str] = None  #: the function that fills it with defaults
    CHOICES: dict[str, type[enum.IntEnum]] = {}  #: members that are one of an enumeration

    def __init__(self, **values: Any) -> None:
        super().__init__()
        if self.INIT is not None:
            room = ctypes.create_string_buffer(ROOM_FOR_INIT)
            into = ctypes.cast(room, ctypes.POINTER(type(self)))
            # A struct that has grown has an init that is told its size; its first one fills what the first header had.
            size = (ctypes.sizeof(self),) if self.INIT.endswith("_sized") else ()
            getattr(lib, self.INIT)(into, *size)
            ctypes.memmove(ctypes.addressof(self), room, ctypes.sizeof(self))
        self.struct_size = ctypes.sizeof(self)
        for name, value in values.items():
            if name not in self.names():
                raise TypeError(self._no_such(name))
            setattr(self, name, value)

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """The members that a user may set or read."""
        return tuple(field[0] for field in cls._fields_ if field[0] not in HIDDEN)

    @classmethod
    def _no_such(cls, name: str) -> str:
        near = difflib.get_close_matches(name, cls.names(), 1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        return f"{cls.__name__} has no {name!r}{hint} It has: {', '.join(cls.names())}"

    def __setattr__(self, name: str, value: Any) -> None:
        kind = dict(self._fields_).get(name)
        if kind is None:
            raise AttributeError(self._no_such(name))
        label = f"{type(self).__name__}.{name}"
        if name in self.CHOICES:
            value = _constants.choose(self.CHOICES[name], value, label)
        if issubclass(kind, ctypes.Array):
            value = tuple(_arrays.vector(label, value, kind._length_, kind._type_).tolist())
        elif issubclass(kind, Struct):
            value = kind(**value) if isinstance(value, Mapping) else value
        elif kind is ctypes.c_double:
            value = _arrays.real(label, value)
        elif issubclass(kind, ctypes._SimpleCData):
            value = _arrays.integer(label, value, kind)
        super().__setattr__(name, value)

    def __getattribute__(self, name: str) -> Any:
        value = super().__getattribute__(name)
        if isinstance(value, ctypes.Array):
            return np.ctypeslib.as_array(value)
        return value.decode() if isinstance(value, bytes) else value

    def __repr__(self) -> str:
        parts = []
        for name in self.names():
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                value = value.tolist()
            elif name in self.CHOICES and value in list(self.CHOICES[name]):
                value = self.CHOICES[name](value).name.lower()
            parts.append(f"{name}={value!r}")
        return f"{type(self).__name__}({', '.join(parts)})"

    def as_dict(self) -> dict[str, Any]:
        """Members by name, arrays as copies."""
        values = {name: getattr(self, name) for name in self.names()}
        return {name: value.copy() if isinstance(value, np.ndarray) else value for name, value in values.items()}


def given(kind: type[Any], struct: Optional[Any], values: dict[str, Any]) -> Any:
    """The struct that a method was given: as an object, or made of its keywords, never both."""
    if struct is None:
        return kind(**values)
    if not isinstance(struct, kind):
        raise TypeError(f"takes a talus.{kind.__name__} or its keywords, was given {type(struct).__name__}")
    if values:
        raise TypeError(f"takes a talus.{kind.__name__} or its keywords, not both")
    return struct
