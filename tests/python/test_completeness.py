"""The binding has all of talus.h, with the compiler's own layout and values. Each failure lists what is missing and where
in capi/python/talus a line is to be added."""

import ctypes
import os
import re
import subprocess

import header
import pytest
from conftest import PACKAGE

from talus import _constants, _functions, _library, _structs

SCALARS = {"int32_t": ctypes.c_int32, "uint32_t": ctypes.c_uint32, "int64_t": ctypes.c_int64, "uint64_t": ctypes.c_uint64,
           "double": ctypes.c_double, "talus_status": ctypes.c_int32, "void": None}
# numpy knows ctypes' types by size as well; "i4" and the like are the names that header.KINDS uses.
KINDS = {ctypes.c_int32: "i4", ctypes.c_uint32: "u4", ctypes.c_int64: "i8", ctypes.c_uint64: "u8", ctypes.c_double: "f8",
         ctypes.c_float: "f4", ctypes.c_char: "S", ctypes.c_char_p: "S*", ctypes.c_void_p: "v*"}


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    return header.measured(tmp_path_factory.mktemp("probe"))


def shown_by_the_library():
    out = subprocess.run(["nm", "-D", "--defined-only", os.path.realpath(_library.lib._name)], capture_output=True, text=True, check=True).stdout
    return {line.split()[-1].split("@")[0] for line in out.splitlines()} - {""}


def expected(c_type):
    """The ctypes type of a C type without const."""
    if c_type in SCALARS:
        return SCALARS[c_type]
    assert c_type.endswith("*"), c_type
    inner = c_type[:-1].strip()
    if inner == "char":
        return ctypes.c_char_p
    if inner in ("void", "talus_engine"):
        return ctypes.c_void_p
    if inner in _structs.STRUCTS:
        return ctypes.POINTER(_structs.STRUCTS[inner])
    return ctypes.POINTER(expected(inner))


def kind(c):
    if issubclass(c, ctypes.Array):
        return KINDS.get(c._type_, "?") + "*"
    if issubclass(c, ctypes._Pointer):
        return KINDS.get(c._type_, "?") + "*"
    return KINDS.get(c, "other")


def test_the_header_is_read():
    assert len(header.functions()) > 50 and len(header.structs()) > 10 and len(header.constant_names()) > 40
    assert header.functions()["talus_engine_step"] == ("talus_status", ["talus_engine *", "int64_t", "int64_t *"])
    assert header.functions()["talus_engine_stress"][1] == ["talus_engine *"] + ["double *"] * 5
    assert header.structs()["talus_phase"] == ["struct_size", "reserved", "name", "min", "mean", "max", "calls"]


def test_every_function_is_bound():
    declared = set(header.functions())
    assert not declared - set(_functions.PROTOTYPES), "add to capi/python/talus/_functions.py"
    assert not set(_functions.PROTOTYPES) - declared, "not in talus.h any more: remove from _functions.py"


def test_the_library_shows_what_the_header_declares():
    assert shown_by_the_library() == set(header.functions()), "is the library that of this source tree?"


def test_every_prototype_is_that_of_the_header():
    wrong = {}
    for name, (result, arguments) in header.functions().items():
        want = (expected(result), [expected(a) for a in arguments])
        if name in _functions.PROTOTYPES and _functions.PROTOTYPES[name] != want:
            wrong[name] = {"bound": _functions.PROTOTYPES[name], "declared": want}
    assert not wrong, "correct in capi/python/talus/_functions.py"


def test_every_function_is_used_by_the_package():
    text = "".join(p.read_text() for p in (PACKAGE / "talus").glob("*.py") if p.name != "_functions.py")
    unused = [name for name in _functions.PROTOTYPES if not re.search(rf'(\blib\.|"){name}\b', text)]
    assert not unused, "bound, but no method of Engine (or function of the package) calls them"


def test_every_struct_is_bound(measured):
    declared = set(header.structs())
    assert not declared - set(_structs.STRUCTS), "add to capi/python/talus/_structs.py"
    assert not set(_structs.STRUCTS) - declared, "not in talus.h any more: remove from _structs.py"


def test_every_struct_has_the_compilers_layout(measured):
    layout, wrong = measured[0], []
    for name, struct in _structs.STRUCTS.items():
        bound = {(name, ""): (0, ctypes.sizeof(struct), "")}
        for member, c in struct._fields_:
            descriptor = getattr(struct, member)
            bound[name, member] = (descriptor.offset, descriptor.size, kind(c))
        true = {key: value for key, value in layout.items() if key[0] == name}
        wrong += [f"{key}: (offset, size, kind) bound {bound.get(key)}, in C {true.get(key)}"
                  for key in sorted(bound.keys() | true.keys()) if bound.get(key) != true.get(key)]
    assert not wrong, "correct in capi/python/talus/_structs.py"


def test_every_init_function_is_that_of_its_struct():
    for name, struct in _structs.STRUCTS.items():
        init = f"{name}_init"
        assert struct.INIT == (init if init in header.functions() else None), struct


def test_every_constant_has_the_headers_value(measured):
    true, bound = measured[1], _constants.header_constants()
    assert {k: v for k, v in true.items() if bound.get(k) != v} == {}, "correct in capi/python/talus/_constants.py"
    assert set(bound) - set(true) == set(), "not in talus.h any more: remove from _constants.py"


def test_every_field_has_a_type():
    assert set(_constants.FIELDS) == set(_constants.Field)


def test_every_status_has_an_exception():
    from talus import errors

    assert set(errors.BY_STATUS) == {int(s) for s in _constants.Status if s < 0}


def test_the_probe_sees_a_wrong_layout(measured):
    """The test of the test: a struct with two members swapped is noticed by kind even where the sizes agree."""
    class Swapped(ctypes.Structure):
        _fields_ = [("struct_size", ctypes.c_int32)]

    assert kind(Swapped._fields_[0][1]) != measured[0]["talus_laws", "struct_size"][2]
