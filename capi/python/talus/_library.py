"""Finds and loads the shared library.

Tried in this order, and the first that exists is taken:
  1. the file that the environment variable TALUS_LIBRARY names;
  2. the library installed with this package (three folders up, so that a prefix may be moved as a whole);
  3. whatever the system's loader finds (LD_LIBRARY_PATH, ldconfig).
"""

from __future__ import annotations

import ctypes
import os
import pathlib

VERSION = (0, 1, 0)  #: of the header that this binding was written for
SONAME = f"libtalus.so.{VERSION[0]}"


def candidates() -> list[str]:
    """The places to look at, best first; a name without a slash is left to the system's loader."""
    given = os.environ.get("TALUS_LIBRARY")
    if given:
        return [given]  # who names a library wants that one or an error, not another that is lying around
    beside = pathlib.Path(__file__).resolve().parents[3] / SONAME
    return [str(beside), SONAME] if beside.exists() else [SONAME]


def load() -> ctypes.CDLL:
    """Load the library and refuse one of another version. CDLL, not PyDLL: the GIL is released during every call."""
    failures = []
    for name in candidates():
        try:
            library = ctypes.CDLL(name)
        except OSError as error:
            failures.append(str(error))
            continue
        check_version(library, name)
        return library
    raise ImportError(
        "the Talus library was not found: " + "; ".join(failures) + ". Set TALUS_LIBRARY to the file "
        f"{SONAME}, or use the package inside of an installed prefix.")


def check_version(library: ctypes.CDLL, name: str) -> None:
    """Before 1.0 a minor version may change structs, so both numbers must be the ones bound here."""
    try:
        function = library.talus_version
    except AttributeError:
        raise ImportError(f"{name} is not a Talus library: it has no talus_version") from None
    function.restype, function.argtypes = ctypes.c_int32, []
    number = function()
    found = (number // 10000, number // 100 % 100, number % 100)
    if found[:2] != VERSION[:2]:
        raise ImportError(
            f"{name} is Talus {found[0]}.{found[1]}.{found[2]}, and this Python package is for {VERSION[0]}.{VERSION[1]}: "
            "take the package that was installed with the library")


lib = load()
