"""Crease patterns: reading, families, closure residuals."""

from __future__ import annotations

import inspect
import io
import json
import operator
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _foldpath
from ._convert import File, Floats, Integers, contiguous, degrees, floats, integers, options, shaped, to_json
from ._error import FoldpathError

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Source = Union[File, bytes, bytearray, memoryview, Mapping[str, Any], "io.IOBase"]


class Pattern:
    """A crease pattern: a flat sheet with its hinges and, if the file has one, a goal.

    ``V`` is the number of vertices and ``E`` that of edges, in the order of the file. Vertices and edges that foldpath
    adds, as where a cut parts the sheet, come after those of the file.
    """

    __slots__ = ("_sheet",)
    _sheet: _foldpath.Sheet

    def __init__(
        self,
        *,
        vertices: ArrayLike,
        edges: ArrayLike,
        letters: Sequence[str] | None = None,
        faces: Iterable[Iterable[int]] | None = None,
        angles: ArrayLike | None = None,
        unit: str | None = None,
        title: str = "pattern",
    ) -> None:
        """Make a pattern from arrays, as :func:`read` does from a FOLD file.

        - ``vertices``: Positions in the flat sheet: (V, 2)
        - ``edges``: Vertices of the edges: (E, 2)
        - ``letters``: FOLD's letter of each edge: M, V, B, F, U, C or J. Without letters, angles tell them
        - ``faces``: Vertices of each panel, counter-clockwise; found by itself if left out
        - ``angles``: Goal angle of each edge, radians, valley positive: (E,), nan where there is none
        - ``unit``: Unit of lengths: nm, um, mm, cm, m, in or pt

        Raises :class:`FoldpathError` if the arrays are no crease pattern.
        """
        places, ends = contiguous(vertices, "vertices"), contiguous(edges, "edges")
        for name, array in (("vertices", places), ("edges", ends)):
            if array.ndim != 2 or array.shape[1] != 2:
                raise FoldpathError(f"{name}: expected two numbers for each, found the shape {array.shape}")
        numbers = ends.astype(np.int64, copy=True) if np.isfinite(ends).all() else None
        if numbers is None or (numbers != ends).any():
            raise FoldpathError("edges: expected whole numbers")
        told: dict[str, Any] = {
            "file_spec": 1.2,
            "file_title": title,
            "frame_classes": ["creasePattern"],
            "vertices_coords": places,
            "edges_vertices": numbers,
        }
        if letters is not None:
            told["edges_assignment"] = list(letters)
        if faces is not None:
            told["faces_vertices"] = [[operator.index(vertex) for vertex in face] for face in faces]
        if angles is not None:
            told["edges_foldAngle"] = degrees(angles, "angles", len(numbers))
        if unit is not None:
            told["frame_unit"] = unit
        self._sheet = _foldpath.Sheet.parse("<arrays>", to_json(told).encode(), "{}")

    @classmethod
    def _of(cls, sheet: _foldpath.Sheet) -> Pattern:
        pattern = cls.__new__(cls)
        pattern._sheet = sheet
        return pattern

    @property
    def title(self) -> str:
        """The title of the file, or else its name."""
        return self._sheet.title

    @property
    def file(self) -> str:
        """The name of the file."""
        return self._sheet.file

    @property
    def unit(self) -> str | None:
        """The unit of lengths, as FOLD names it; ``None`` if the file tells none."""
        return self._sheet.unit

    @property
    def notes(self) -> list[str]:
        """Repairs and assumptions made while reading, in sentences."""
        return self._sheet.notes

    @property
    def vertices(self) -> Floats:
        """Positions of the vertices in the flat sheet: (V, 2)."""
        return floats(self._sheet.vertices(), -1, 2)

    @property
    def edges(self) -> Integers:
        """Vertices of the edges: (E, 2)."""
        return integers(self._sheet.edges(), -1, 2)

    @property
    def faces(self) -> list[list[int]]:
        """Vertices of each panel, counter-clockwise."""
        return self._sheet.faces()

    @property
    def letters(self) -> list[str]:
        """FOLD's letter of each edge: M, V, B, F, U, C or J."""
        return list(self._sheet.letters)

    @property
    def hinges(self) -> Integers:
        """Numbers of the edges that are hinges."""
        return integers(self._sheet.hinges(), -1)

    @property
    def goal(self) -> Floats:
        """Goal angle of each edge, radians, valley positive: (E,), nan where there is none."""
        return floats(self._sheet.goal(), -1)

    @property
    def closure_vertices(self) -> Integers:
        """Vertices of the first rows of :func:`closure`, in their order."""
        return integers(self._sheet.closure_vertices(), -1)

    def info(self, timeout: float | None = None) -> dict[str, Any]:
        """Describe the pattern, and foresee whether it folds: the object of ``foldpath info --json``.

        ``timeout`` (seconds) ends the search for crease groups and the forecast.
        """
        described: dict[str, Any] = json.loads(self._sheet.info(timeout))
        return described

    def to_dict(self) -> dict[str, Any]:
        """Return the pattern in the form of FOLD, with vertices, edges, letters, panels and goal angles."""
        told: dict[str, Any] = {
            "file_spec": 1.2,
            "file_creator": "foldpath",
            "file_title": self.title,
            "frame_classes": ["creasePattern"],
            "vertices_coords": self.vertices.tolist(),
            "edges_vertices": self.edges.tolist(),
            "edges_assignment": self.letters,
            "faces_vertices": self.faces,
        }
        if self.unit is not None:
            told["frame_unit"] = self.unit
        goal = degrees(self.goal, "goal", len(self.edges))
        if any(angle is not None for angle in goal):
            told["edges_foldAngle"] = goal
        return told

    def moved(self, vertices: ArrayLike) -> Pattern:
        """Return the pattern with its vertices at other places, (V, 2), in their order.

        Raises :class:`FoldpathError` if panels or edges are no longer those of this pattern.
        """
        places = shaped(vertices, "vertices", self.vertices.shape)
        moved = Pattern._of(
            _foldpath.Sheet.parse(self.file, to_json({**self.to_dict(), "vertices_coords": places}).encode(), "{}")
        )
        if moved.vertices.shape != places.shape or not np.array_equal(moved.edges, self.edges):
            raise FoldpathError("vertices: expected places that keep the panels, found others")
        return moved

    def save(self, file: File) -> None:
        """Write the pattern as a FOLD file. It is written whole or not at all."""
        if not os.fsdecode(file).lower().endswith(".fold"):
            raise FoldpathError(f"{os.fsdecode(file)}: expected a name that ends in .fold")
        _foldpath.write_text(file, to_json(self.to_dict()))

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, self._sheet.source()

    def __repr__(self) -> str:
        hinges = len(self.hinges)
        return f"<foldpath.Pattern {self.title!r}: {len(self.faces)} panels, {hinges} hinges>"


def _again(name: str, data: bytes, reading: str) -> Pattern:
    """Make a pattern again that was pickled."""
    return Pattern._of(_foldpath.Sheet.parse(name, data, reading))


def read(
    source: Source,
    *,
    tolerance: float | None = None,
    straighten: Literal["auto", "on", "off"] = "auto",
    frame: int | None = None,
    unit: Literal["nm", "um", "mm", "cm", "m", "in", "pt"] | None = None,
    colors: str | None = None,
    layers: str | None = None,
    dashes: Literal["V", "M", "F", "U"] | None = None,
) -> Pattern:
    """Read a crease pattern.

    ``source`` is the name of a file (FOLD, SVG, CP, OPX or OBJ), its bytes, a binary file that is open, or a dictionary
    in the form of FOLD. The options are those of the command line.

    The options:

    - ``tolerance``: Distance within which lines of a drawing are meant to meet, in the drawing's own units. By
      default it is a thousandth of the median line, but at most 1e-4 of the diagonal. Notes name the tolerance that
      keeps lines which end in the open. For SVG, DXF, CP and OPX files, and FOLD files without faces
    - ``straighten``: Move vertices a little, so that lines are straight or parallel and creases fold flat that nearly
      do. No vertex moves farther than twice the tolerance. By default only sheets that do not fold as they are drawn
      are straightened. Notes tell how many vertices are moved, and by how much
    - ``frame``: Frame of a FOLD file with the crease pattern; the key frame is 0. By default it is the first frame of
      class creasePattern, or else the key frame. A note names other frames that have a crease pattern. Goals come
      only from folded frames that inherit from the frame
    - ``unit``: Unit of the lengths of a file that names none. A unit that differs from that of the file is an error.
      Places, lengths, paths and models have the unit of the file
    - ``colors``: Letters of the colours of an SVG or DXF drawing, such as red=V,blue=M,#00ff00=V. Colours are names
      of CSS or digits such as #00ff00; letters are B (border), M, V, F (flat), U (free), C (cut) and J (joins a
      panel). A colour that is not named counts as the nearest named colour of its hue; without one it has the meaning
      of Origami Simulator
    - ``layers``: Letters of the layers of a DXF drawing, such as CUT=C,CREASE=V. Letters are those of ``colors``. A
      layer that is not named has the letter that its name says (words such as CUT, BORDER, MOUNTAIN, VALLEY, CREASE),
      or else its lines have the letters of their colours; notes tell which
    - ``dashes``: Letter of the dashed lines of an SVG or DXF drawing, whatever their colour. Without this option
      dashes mean nothing: a dashed line has the letter of its colour or layer

    Raises :class:`FoldpathError` if the source holds no crease pattern.
    """
    given = dict(locals())
    given.pop("source")
    reading = options(given)
    if isinstance(source, (str, os.PathLike)):
        return Pattern._of(_foldpath.Sheet.read(source, reading))
    return Pattern._of(_foldpath.Sheet.parse("<bytes>", content(source), reading))


#: Names of the options of :func:`read`.
READING = [name for name in inspect.signature(read).parameters if name != "source"]


def content(source: Source) -> bytes:
    """Return the bytes of a source that is no name of a file."""
    if isinstance(source, Mapping):
        return to_json(source).encode()
    if isinstance(source, (bytes, bytearray, memoryview)):
        return bytes(source)
    if hasattr(source, "read"):
        data = source.read()
        return data.encode() if isinstance(data, str) else bytes(data)
    raise FoldpathError(f"expected a file, bytes or a dictionary, found {type(source).__name__}")


def closure(
    pattern: Pattern, angles: ArrayLike, *, wrt: Literal["angles", "vertices"] = "angles"
) -> tuple[Floats, csr_matrix]:
    """Return closure residuals at fold angles, and their Jacobian.

    ``angles`` has the fold angle of each edge in radians, valley positive: (E,). Angles of edges that are no hinge count
    for nothing and may be nan, as in :attr:`Motion.fold_angles`.

    Residuals are (R, 3), zero exactly if the sheet closes: a row for each of ``pattern.closure_vertices``, and after
    these two for each hole, of rotation and of translation over the hole's size. The residual of a vertex is the vector
    part of the unit quaternion of the turn round it, doubled; near 0 its length is that turn in radians. The Jacobian is
    a sparse matrix of scipy, (3 R, E): row 3 i + k belongs to residual (i, k).

    With ``wrt="vertices"`` the Jacobian is that by the vertices of the flat pattern, (3 R, 2 V): column 2 v belongs to x of
    vertex v, column 2 v + 1 to y. Middle and size of a hole count as fixed.
    """
    from scipy.sparse import csr_matrix

    values = contiguous(angles, "angles")
    if values.ndim != 1:
        raise FoldpathError(f"angles: expected one dimension, found {values.ndim}")
    if wrt not in ("angles", "vertices"):
        raise FoldpathError(f"wrt: expected angles or vertices, found {wrt}")
    by_vertices = wrt == "vertices"
    residuals, data, columns, ends = pattern._sheet.closure(values.tobytes(), by_vertices)
    rows = floats(residuals, -1, 3)
    matrix = csr_matrix(
        (floats(data, -1), integers(columns, -1), integers(ends, -1)),
        shape=(rows.size, 2 * len(pattern.vertices) if by_vertices else len(values)),
    )
    return rows, matrix


def _family(family: str, parameters: Mapping[str, Any]) -> Pattern:
    return Pattern._of(_foldpath.Sheet.generate(to_json({"family": family, **parameters})))


# The families, made of the table in host/src/request/families.rs.


def miura(rows: int, columns: int, angle: float = 60.0, fold: float = 0.9) -> Pattern:
    """Miura fold of rows x columns parallelograms with sides of length 1.

    - ``rows``: Number of rows
    - ``columns``: Number of columns
    - ``angle``: Sector angle, degrees
    - ``fold``: Goal: fold angle of the zigzag creases, as a fraction of 180 degrees
    """
    return _family("miura", locals())


def waterbomb(rows: int, columns: int, fold: float = 0.5) -> Pattern:
    """Waterbomb tessellation on rows x columns unit squares; rows are counted round the tube.

    - ``rows``: Number of rows
    - ``columns``: Number of columns
    - ``fold``: Goal: fold angle of the boundary lines, as a fraction of 180 degrees
    """
    return _family("waterbomb", locals())


def yoshimura(rows: int, columns: int, angle: float = 30.0, fold: float = 0.25) -> Pattern:
    """Yoshimura pattern on rows x columns cells with one diagonal each.

    - ``rows``: Number of rows
    - ``columns``: Number of columns
    - ``angle``: Angle between diagonals and straight creases, degrees
    - ``fold``: Goal: fold angle of the straight creases, as a fraction of 180 degrees
    """
    return _family("yoshimura", locals())


def quad(rows: int = 24, columns: int = 24, fold: float = 0.0675) -> Pattern:
    """Slender parallelograms with one diagonal each, all creases valley; this sheet cannot fold.

    - ``rows``: Number of rows
    - ``columns``: Number of columns
    - ``fold``: Goal: fold angle of the diagonals, as a fraction of 180 degrees
    """
    return _family("quad", locals())


def square_twist(rows: int = 1, columns: int = 1, angle: float = 60.0, letters: Literal["foldable", "unfoldable"] = "foldable", fold: float = 0.5) -> Pattern:
    """Square twists on rows x columns tiles; each tile mirrors its neighbours.

    - ``rows``: Number of rows
    - ``columns``: Number of columns
    - ``angle``: Angle between the sides of a square and its pleats, degrees
    - ``letters``: Letters with which the sheet folds, or with which it does not
    - ``fold``: Goal of foldable letters: fold angle of the creases that turn most, as a fraction of 180 degrees
    """
    return _family("square-twist", locals())


def resch(rows: int = 3, columns: int = 3) -> Pattern:
    """Ron Resch's triangular tessellation of rows x columns stars; its goal is closed to a plane.

    - ``rows``: Number of rows
    - ``columns``: Number of columns
    """
    return _family("resch", locals())


def kresling(rows: int = 2, columns: int = 6) -> Pattern:
    """Flat conical Kresling pattern: rows rings round a polygon of columns sides. The goal closes, but no motion leads to it.

    - ``rows``: Number of rings
    - ``columns``: Number of sides of the polygon, even
    """
    return _family("kresling", locals())
