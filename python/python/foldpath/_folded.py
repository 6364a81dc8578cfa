"""The folded sheet as a function of its flat vertices and of its drivers, for packages that differentiate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ._convert import Floats, contiguous, floats, shaped
from ._error import FoldpathError
from ._motion import Motion
from ._pattern import Pattern, closure

#: Arrays of the sheet: fold angles (E,), folded vertices (V, 3).
Shape = tuple[Floats, Floats]
#: Gradients by the vertices of the flat pattern, (V, 2), and by the drivers, (D,).
Gradients = tuple[Floats, Floats]


class Folded:
    """The sheet of a motion at a time, with flat vertices and drivers that may be others."""

    def __init__(self, motion: Motion, t: float) -> None:
        self.pattern = motion.pattern
        self.drivers = motion.drivers(t)
        self.angles = motion.at(t)
        self.flat = self.pattern.vertices

    def arguments(self, vertices: ArrayLike | None, drivers: ArrayLike | None) -> Gradients:
        """Return vertices and drivers as arrays; those left out are those of the motion."""
        flat = self.flat if vertices is None else shaped(vertices, "vertices", self.flat.shape)
        driven = self.angles[self.drivers] if drivers is None else contiguous(drivers, "drivers")
        return flat, shaped(driven, "drivers", (len(self.drivers),))

    def fold(self, vertices: Floats, drivers: Floats) -> Shape:
        """Return fold angles and folded vertices of the closed sheet."""
        pattern = self.pattern.moved(vertices)
        sheet = pattern._sheet
        angles = sheet.driven(self._start(self.angles), self.drivers, drivers.tobytes())
        return floats(angles, -1), floats(sheet.folded(bytes(angles)), -1, 3)

    def vjp(self, vertices: Floats, angles: Floats, by_angles: Floats, by_places: Floats) -> Gradients:
        """Return the gradient of what has these gradients by the results of :meth:`fold`, of which ``angles`` is one."""
        sheet = self.pattern.moved(vertices)._sheet
        by = np.ascontiguousarray(by_angles).tobytes(), np.ascontiguousarray(by_places).tobytes()
        flat, driven = sheet.vjp(self._start(angles), self.drivers, *by)
        return floats(flat, -1, 2), floats(driven, -1)

    def jvp(self, vertices: Floats, angles: Floats, change: Floats, driven: Floats) -> Shape:
        """Return the rates of the results of :meth:`fold` for a change of vertices and drivers."""
        sheet = self.pattern.moved(vertices)._sheet
        by = np.ascontiguousarray(change).tobytes(), np.ascontiguousarray(driven).tobytes()
        turned, moved = sheet.jvp(self._start(angles), self.drivers, *by)
        return floats(turned, -1), floats(moved, -1, 3)

    @staticmethod
    def _start(angles: Floats) -> bytes:
        return np.ascontiguousarray(angles, dtype=np.float64).tobytes()


class Closed:
    """Closure residuals of a pattern, whose flat vertices may be others."""

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern

    def residuals(self, angles: Floats, vertices: Floats) -> Floats:
        """Return the residuals, (R, 3)."""
        return closure(self.pattern.moved(vertices), angles)[0]

    def vjp(self, angles: Floats, vertices: Floats, by: Floats) -> tuple[Floats, Floats]:
        """Return the gradient by angles, (E,), and by vertices, (V, 2)."""
        pattern, by = self.pattern.moved(vertices), np.asarray(by, dtype=np.float64).ravel()
        gradients = [closure(pattern, angles, wrt=wrt)[1].T @ by for wrt in ("angles", "vertices")]
        return gradients[0], gradients[1].reshape(-1, 2)

    def jvp(self, angles: Floats, vertices: Floats, turned: Floats, moved: Floats) -> Floats:
        """Return the rates of the residuals, (R, 3)."""
        pattern, changes = self.pattern.moved(vertices), {"angles": np.nan_to_num(turned), "vertices": moved.ravel()}
        rates = [closure(pattern, angles, wrt=wrt)[1] @ change for wrt, change in changes.items()]  # type: ignore[arg-type]
        rate: Floats = sum(rates).reshape(-1, 3)
        return rate


def missing(name: str, packages: Sequence[str]) -> ImportError:
    """Return the error of a package that is not installed."""
    text = f"foldpath.{name} needs {' and '.join(packages)}, which foldpath does not install: pip install {' '.join(packages)}"
    return ImportError(text, name=name)
