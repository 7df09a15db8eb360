"""What a caller passes, turned into what C reads: contiguous memory of the right type and shape, or a clear error.

Conversions that would change a value without notice (a fraction to an integer, an integer out of range, a complex
number) are refused; a plain change of layout or of width is a copy."""

from __future__ import annotations

import ctypes
from typing import Any, Optional

import numpy as np

Array = np.ndarray[Any, Any]


def converted(name: str, value: object, dtype: Any) -> Array:
    """A C-contiguous array of the type; the input itself if it already is one."""
    dtype = np.dtype(dtype)
    try:
        array = np.asarray(value)
    except ValueError as error:  # rows of different lengths
        raise ValueError(f"{name}: not a regular array ({error})") from None
    if array.size == 0:
        return np.zeros(array.shape, dtype)
    wanted = "biuf" if dtype.kind == "f" else "biu"
    if array.dtype.kind not in wanted:
        what = "real numbers" if dtype.kind == "f" else "whole numbers"
        raise TypeError(f"{name}: takes {what}, was given type {array.dtype}")
    if dtype.kind != "f":
        limits = np.iinfo(dtype)
        low, high = int(array.min()), int(array.max())
        if low < limits.min or high > limits.max:
            raise ValueError(f"{name}: {low if low < limits.min else high} does not fit in {dtype}")
    return np.asarray(array, dtype, order="C")


def vector(name: str, value: object, length: int = 3, dtype: Any = "f8") -> Array:
    """So many numbers."""
    array = converted(name, value, dtype)
    if array.shape != (length,):
        raise ValueError(f"{name}: takes {length} numbers, was given shape {array.shape}")
    return array


def rows(name: str, value: object, count: int, components: int, dtype: Any) -> Optional[Array]:
    """One row a grain; a single row (or number) is taken for all of them; None stays None."""
    if value is None:
        return None
    array = converted(name, value, dtype)
    shape = (count,) if components == 1 else (count, components)
    if array.shape == shape:
        return array
    if array.shape == shape[1:]:
        return np.ascontiguousarray(np.broadcast_to(array, shape))
    raise ValueError(f"{name}: takes shape {shape}" + (" or one number" if components == 1 else " or (3,)") + f", was given {array.shape}")


def integer(name: str, value: Any, dtype: Any) -> int:
    """One whole number in the range of the type. ctypes itself would cut off the upper bits without a word."""
    array = converted(name, value, dtype)
    if array.shape != ():
        raise ValueError(f"{name}: takes one whole number, was given shape {array.shape}")
    return int(array)


def real(name: str, value: Any) -> float:
    """One real number."""
    array = converted(name, value, "f8")
    if array.shape != ():
        raise ValueError(f"{name}: takes one number, was given shape {array.shape}")
    return float(array)


def pointer(array: Optional[Array], kind: Any) -> Any:
    """The array's memory for C. The caller keeps the array alive during the call."""
    return None if array is None else array.ctypes.data_as(ctypes.POINTER(kind))


def doubles(name: str, value: object, length: int = 3) -> Any:
    """A C array of doubles, which owns its memory."""
    return (ctypes.c_double * length)(*vector(name, value, length))
