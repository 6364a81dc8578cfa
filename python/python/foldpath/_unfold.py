"""Crease patterns of folded shapes."""

from __future__ import annotations

import os
from typing import Literal

from . import _foldpath
from ._answer import Answer
from ._convert import options
from ._pattern import Pattern, Source, content


class Unfolding(Answer):
    """The answer to :func:`unfold`: the outcome is ``unfolded``, ``not_developable`` or ``overlap``."""

    __slots__ = ("_notes", "_pattern")
    _notes: list[str]
    _pattern: Pattern | None

    def __init__(
        self, outcome: str, reason: str | None, text: str, notes: list[str], pattern: Pattern | None
    ) -> None:
        super().__init__(outcome, reason, text)
        self._notes = notes
        self._pattern = pattern

    @property
    def notes(self) -> list[str]:
        """Notes on the shape and its pattern, in sentences."""
        return list(self._notes)

    @property
    def pattern(self) -> Pattern | None:
        """The crease pattern, whose goal is the shape; ``None`` if there is none."""
        return self._pattern


def unfold(
    shape: Source,
    *,
    frame: int | None = None,
    unit: Literal["nm", "um", "mm", "cm", "m", "in", "pt"] | None = None,
    max_defect: float = 0.01,
    cut: Literal["auto", "none"] = "auto",
) -> Unfolding:
    """Make a crease pattern of a folded shape, with its measured fold angles as the goal, as ``foldpath unfold`` does.

    ``shape`` is the name of a file (FOLD with faces in space, OBJ or STL), its bytes, a binary file that is open, or a
    dictionary in the form of FOLD.

    Raises :class:`FoldpathError` if the shape is no surface, or for bad options. A shape that does not unfold is an outcome,
    not an error.

    The options:

    - ``frame``: Frame of a FOLD file; the key frame is 0 [default: the last folded form, or else the key frame]
    - ``unit``: Unit of the lengths of a shape whose file names none. A unit that differs from that of the file is an
      error. The crease pattern has the unit
    - ``max_defect``: Largest error of the shape that is taken for noise, degrees. This bounds the angle defect of an
      inner vertex and the slope of a face out of its plane. Defects that the rounding of the file's coordinates
      explains, by their digits, are taken for noise as well
    - ``cut``: Which shapes are cut so that they lie flat
    """
    given = dict(locals())
    given.pop("shape")
    named = isinstance(shape, (str, os.PathLike))
    name, data = (shape, None) if named else ("<bytes>", content(shape))
    told, notes, sheet = _foldpath.unfold(name, data, options(given))  # type: ignore[arg-type]
    return Unfolding._of(told, notes, None if sheet is None else Pattern._of(sheet))
