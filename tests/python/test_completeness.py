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

SCALARS = {"size_t": ctypes.c_size_t, "int32_t": ctypes.c_int32, "uint32_t": ctypes.c_uint32, "int64_t": ctypes.c_int64, "uint64_t": ctypes.c_uint64,
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
    """The ctypes type of a C type without const; a text if the binding has nothing for it."""
    c_type = header.callbacks().get(c_type, c_type)
    callback = re.fullmatch(r"(.*?)\s*\(\*\)\s*\((.*)\)", c_type)
    if callback:
        return ctypes.CFUNCTYPE(expected(callback[1]), *(expected(a) for a in header.arguments_of(callback[2])))
    if c_type in SCALARS:
        return SCALARS[c_type]
    inner = c_type[:-1].strip()
    if inner == "char":
        return ctypes.c_char_p
    if inner in ("void", "talus_engine", "talus_kept"):
        return ctypes.c_void_p
    if inner in _structs.STRUCTS:
        return ctypes.POINTER(_structs.STRUCTS[inner])
    return ctypes.POINTER(expected(inner)) if inner in SCALARS or inner.endswith("*") else f"no struct for {c_type!r}"


def kind(c):
    if issubclass(c, (ctypes.Array, ctypes._Pointer)):
        return KINDS.get(c._type_, "?") + "*"
    return KINDS.get(c, "other")


def none(found, what):
    """Fail with all of a list, which pytest's own report would cut short."""
    if found:
        pytest.fail(f"{what}:\n  " + "\n  ".join(sorted(found)), pytrace=False)


def test_the_header_is_read():
    assert len(header.functions()) > 50 and len(header.structs()) > 10 and len(header.constant_names()) > 40
    assert header.functions()["talus_engine_generation"] == ("talus_status", ["talus_engine *", "uint64_t *"])
    assert header.functions()["talus_engine_stress"][1] == ["talus_engine *"] + ["double *"] * 5
    assert header.structs()["talus_phase"] == ["struct_size", "reserved", "name", "min", "mean", "max", "calls"]


def test_every_function_is_bound():
    declared = set(header.functions())
    missing, extra = declared - set(_functions.PROTOTYPES), set(_functions.PROTOTYPES) - declared
    none(missing, "functions of talus.h to add to capi/python/talus/_functions.py")
    none(extra, "functions to remove from capi/python/talus/_functions.py: talus.h has them no more")


def test_the_library_shows_what_the_header_declares():
    shown, declared = shown_by_the_library(), set(header.functions())
    none(declared - shown, "declared in talus.h but not in the library (is it that of this source tree?)")
    none(shown - declared, "in the library but not declared in talus.h (is it that of this source tree?)")


def test_every_prototype_is_that_of_the_header():
    wrong = []
    for name, (result, arguments) in header.functions().items():
        want = (expected(result), [expected(a) for a in arguments])
        if name in _functions.PROTOTYPES and _functions.PROTOTYPES[name] != want:
            wrong.append(f"{name}: bound {_functions.PROTOTYPES[name]}, declared {want}")
    none(wrong, "prototypes to correct in capi/python/talus/_functions.py")


def test_every_function_is_used_by_the_package():
    text = "".join(p.read_text() for p in (PACKAGE / "talus").glob("*.py") if p.name != "_functions.py")
    # A new program fills a struct by the init that is told its size, where there are two.
    needed = [name for name in _functions.PROTOTYPES if f"{name}_sized" not in _functions.PROTOTYPES]
    unused = [name for name in needed if not re.search(rf'(\blib\.|"){name}\b', text)]
    none(unused, "bound, but called by no method of Engine nor function of the package")


def test_every_struct_is_bound(measured):
    declared = set(header.structs())
    missing, extra = declared - set(_structs.STRUCTS), set(_structs.STRUCTS) - declared
    none(missing, "structs of talus.h to add to capi/python/talus/_structs.py")
    none(extra, "structs to remove from capi/python/talus/_structs.py: talus.h has them no more")


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
    none(wrong, "members to correct in capi/python/talus/_structs.py")


def test_every_init_function_is_that_of_its_struct():
    for name, struct in _structs.STRUCTS.items():
        wanted = [init for init in (f"{name}_init_sized", f"{name}_init") if init in header.functions()]
        assert struct.INIT == (wanted[0] if wanted else None), struct


def test_every_constant_has_the_headers_value(measured):
    true, bound = measured[1], _constants.header_constants()
    none([f"{k} = {v}, bound {bound.get(k)}" for k, v in true.items() if bound.get(k) != v], "constants to correct in capi/python/talus/_constants.py")
    none(set(bound) - set(true), "constants to remove from capi/python/talus/_constants.py: talus.h has them no more")


def test_every_field_has_a_type():
    assert set(_constants.FIELDS) == set(_constants.Field)
    assert set(_constants.CONTACT_FIELDS) == set(_constants.ContactField)


def test_every_status_has_an_exception():
    from talus import errors

    assert set(errors.BY_STATUS) == {int(s) for s in _constants.Status if s < 0}
