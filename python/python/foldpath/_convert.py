"""Arrays, options and names on their way to the extension module and back."""

from __future__ import annotations

import json
import math
import operator
import os
from collections.abc import Iterable, Mapping
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._error import FoldpathError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
File = Union[str, "os.PathLike[str]"]

_PROCESS = os.getpid()


#: Largest number of threads of a call.
_MOST_JOBS = 1024


def threads(jobs: int | None) -> int | None:
    """Return the number of threads that a call was asked to use, if it is one that the command line takes."""
    if jobs is None:
        return None
    try:
        number = operator.index(jobs)
    except TypeError:
        number = 0
    if not 1 <= number <= _MOST_JOBS:
        raise FoldpathError(f"--jobs: expected a whole number from 1 to {_MOST_JOBS}, found {jobs!r}")
    return number


def is_forked() -> bool:
    """Return whether this process was forked after the package was imported."""
    return os.getpid() != _PROCESS


def floats(data: bytearray, *shape: int) -> Floats:
    """Return numbers from the extension module as an array that owns its memory."""
    return np.frombuffer(data, dtype=np.float64).reshape(shape)


def integers(data: bytearray, *shape: int) -> Integers:
    """Return integers from the extension module as an array that owns its memory."""
    return np.frombuffer(data, dtype=np.int64).reshape(shape)


def contiguous(values: ArrayLike, name: str) -> Floats:
    """Return numbers of any type and order as contiguous 64-bit floats."""
    try:
        return np.asarray(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise FoldpathError(f"{name}: expected numbers: {error}") from None


def shaped(values: ArrayLike, name: str, shape: tuple[int, ...]) -> Floats:
    """Return numbers as :func:`contiguous` does, if they have this shape."""
    array = contiguous(values, name)
    if array.shape != shape:
        raise FoldpathError(f"{name}: expected the shape {shape}, found {array.shape}")
    return array


def degrees(angles: ArrayLike, name: str, edges: int) -> list[float | None]:
    """Return the angles of some edges (radians) as FOLD has them: in degrees, with ``None`` for nan."""
    values = np.degrees(shaped(angles, name, (edges,)))
    if np.isinf(values).any():
        raise FoldpathError(f"{name}: expected finite angles or nan, found infinity")
    return [None if math.isnan(value) else value for value in values.tolist()]


def _plain(value: Any) -> Any:
    """Return a value that JSON has: numbers of numpy and names of files are converted."""
    if isinstance(value, bool) or value is None or isinstance(value, (int, str)):
        return value
    if isinstance(value, np.ndarray):
        return [_plain(item) for item in value.tolist()]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float):
        # JSON has no infinity and no nan; their texts are refused by name.
        return value if math.isfinite(value) else str(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [_plain(item) for item in value]
    raise FoldpathError(f"expected a number, a text or a list, found {value!r}")


def to_json(value: Any) -> str:
    """Return the value as JSON in one line."""
    return json.dumps(_plain(value), allow_nan=False, ensure_ascii=False)


def options(given: Mapping[str, Any]) -> str:
    """Return those options that are given as a JSON object."""
    return to_json({name: _option(value) for name, value in given.items() if value is not None})


def _option(value: Any) -> Any:
    """Return the value of an option as the command line has it; a dictionary becomes texts of edges with angles."""
    if isinstance(value, Mapping):
        return [_edge_with(edge, angle) for edge, angle in value.items()]
    if isinstance(value, (str, bytes, os.PathLike, np.ndarray)) or not isinstance(value, Iterable):
        return value
    return list(value)


def _edge_with(edge: Any, angle: Any) -> str:
    """Return a text such as ``4=-45`` or ``7=-30..60``, in degrees."""
    try:
        number = operator.index(edge)
        if np.ndim(angle):
            lower, upper = (float(end) for end in angle)
            return f"{number}={lower!r}..{upper!r}"
        return f"{number}={float(angle)!r}"
    except (TypeError, ValueError):
        text = "expected the number of an edge with an angle, or with a lower and an upper angle"
        raise FoldpathError(f"{text}, found {edge!r}: {angle!r}") from None
