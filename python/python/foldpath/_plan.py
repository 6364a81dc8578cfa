"""Plans."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _foldpath
from ._answer import Answer
from ._convert import File, degrees, is_forked, options, shaped, threads, to_json
from ._error import FoldpathError
from ._motion import Motion
from ._pattern import READING, Pattern, Source, read


class Plan(Answer):
    """The answer to :func:`plan`: the outcome is ``planned`` if the goal is reached and everything asked is proved."""

    __slots__ = ("_motion",)
    _motion: Motion | None

    def __init__(
        self, outcome: str, reason: str | None, text: Union[str, Callable[[], str]], motion: Motion | None
    ) -> None:
        super().__init__(outcome, reason, text)
        self._motion = motion

    @property
    def motion(self) -> Motion | None:
        """The motion as far as it goes; ``None`` if none was found.

        Only if the outcome is ``planned`` does it reach the goal.
        """
        return self._motion

    def __reduce__(self) -> tuple[Any, ...]:
        return Plan, (self._outcome, self._reason, self._json(), self._motion)


def plan(
    pattern: Union[Pattern, Source],
    *,
    goal: File | ArrayLike | None = None,
    fold: float | None = None,
    crease: Mapping[int, float] | Iterable[str] | str | None = None,
    via: Iterable[File | ArrayLike] | File | None = None,
    order: str | None = None,
    orders: int | None = None,
    goal_tolerance: float = 1.0,
    thickness: float | str | None = None,
    hinge_plane: float | str = "middle",
    panels: Literal["taper", "inset"] = "taper",
    gap: float = 0.0,
    margin: float = 0.0,
    limit: Mapping[int, tuple[float, float]] | Iterable[str] | str | NDArray[np.float64] | None = None,
    keep: bool = False,
    symmetry: Literal["auto", "off"] = "auto",
    vertices: Literal["essential", "all"] = "essential",
    reuse: Literal["auto", "off"] | None = None,
    collision: Literal["on", "off"] = "on",
    interpolation: Literal["auto", "half-angle", "hermite", "homogeneous", "linear"] = "auto",
    max_speed: float = 45.0,
    max_accel: float | None = None,
    pace: Literal["optimal", "sparse"] = "optimal",
    max_knots: int | None = None,
    frames: Literal["full", "angles"] = "full",
    solver: Literal["lm", "gradient"] = "lm",
    search: Literal["auto", "path", "random"] = "auto",
    objective: Literal["max", "sum"] = "max",
    seed: int = 0,
    timeout: float | None = None,
    bound: float = 0.01,
    bend: float = 0.0,
    contact: float | None = None,
    tolerance: float | None = None,
    straighten: Literal["auto", "on", "off"] | None = None,
    frame: int | None = None,
    unit: Literal["nm", "um", "mm", "cm", "m", "in", "pt"] | None = None,
    colors: str | None = None,
    layers: str | None = None,
    dashes: Literal["V", "M", "F", "U"] | None = None,
    jobs: int | None = None,
    limits: Mapping[int, tuple[float, float]] | NDArray[np.float64] | None = None,
) -> Plan:
    """Find a path from the flat sheet to a goal.

    Every option is that of ``foldpath plan``, by its name and in its units: degrees and seconds. ``crease`` may be a
    dictionary from edges to degrees, ``limit`` one from edges to ranges of degrees. In place of files, ``goal`` and the
    members of ``via`` may be arrays of the fold angle of each edge in radians, (E,), nan where it is free; ``limit`` may be one
    of the lower and the upper angle of each edge, (E, 2), nan where there is none. ``limits``
    is another name of ``limit``. Options of reading, such as ``unit``, are for patterns that are yet to be read. ``keep`` changes nothing here: ``motion`` is always the path as
    far as it goes.

    The interpreter's lock is released, and Ctrl-C ends the plan. ``jobs`` threads share the work; by default one for each
    core, and one in a process that was forked.

    Raises :class:`FoldpathError`, a ``ValueError`` with the text of the command line, for bad input or options. An answer
    without a motion is an outcome, not an error.

    The options:

    - ``goal``: FOLD file of the same sheet whose fold angles are the goal
    - ``fold``: Fold each crease by this fraction of a half turn, as its letter says. With 0 the goal is the flat
      sheet. Together with ``via`` the path then leads back to flat
    - ``crease``: Drive a crease, edge I of the file, to an angle in degrees while the others follow; repeatable.
      Edges are counted from 0
    - ``via``: FOLD file of the same sheet with fold angles at which the path rests before the goal; repeatable. The
      path passes through several such files in the order given
    - ``order``: Steps of edges that fold one after the other, such as "0-3 / 8-11 / 5=135,lid / 5", or a FOLD file of
      such steps. In its step each edge goes to its goal angle, or to the angle given, in degrees; an edge may stand
      in several steps. A name, as the id of a shape or group in SVG or a layer in DXF, stands for all edges that have
      it; `info --edges` lists numbers and names. Edges that stand nowhere fold in a last step. Borders are skipped.
      The path rests between the steps. Hinges of other steps move only as closure requires. A name of digits and
      hyphens alone, or with one of the signs / , = in it, stands in quotation marks: '"0" / "a-b"'. In a FOLD file of
      the same sheet, whose name ends in .fold, each frame beside the key frame that has fold angles is a step
    - ``orders``: Largest number of orders to list in which the hinges of a net may fold, in the words of ``order``.
      In any two of them some hinges fold in the opposite order. The path folds in the first. Orders are found if the
      hinges turn freely, as where no vertex lies inside the sheet and there is no hole that hinges go round
    - ``goal_tolerance``: Largest distance of a crease from its goal angle at the end of the path, degrees
    - ``thickness``: Make the panels plates of this thickness, in the drawing's unit, or as thick as the motion allows
      (max). The motion is that of the thin sheet; plates are trimmed at hinges as far as it needs, and are judged
      along it: no two of them may pass through each other. With max the answer names a thickness that is proved, and
      one at most 1 % larger that is not possible, with what is in the way
    - ``hinge_plane``: Height of the hinges in the plates: middle, top, bottom, or a fraction of the thickness from
      the lower face
    - ``panels``: Sides of plates at hinges
    - ``gap``: With ``panels`` inset: least distance of the sides of plates from a hinge, in the drawing's unit
    - ``margin``: Angle by which hinges could turn farther than the motion does before plates touch, degrees
    - ``limit``: Keep the hinge at edge I of the file between two angles in degrees; repeatable. Edges are counted
      from 0
    - ``keep``: Write the path as far as it goes, even if the answer is no
    - ``symmetry``: Unknowns of the plan: crease groups, or single creases
    - ``vertices``: Vertices whose closure conditions are solved
    - ``collision``: Search for faces that pass through each other
    - ``interpolation``: Interpolation of the motion between knots
    - ``max_speed``: Largest speed of a hinge, degrees per second
    - ``max_accel``: Largest acceleration of a hinge, degrees per second squared [default: no limit]. With such a
      limit the path begins and ends at rest
    - ``pace``: Time law along the path
    - ``max_knots``: Largest number of knots of the path [default: no limit]
    - ``frames``: Data that each knot stores
    - ``solver``: Solver that closes the sheet
    - ``search``: Method by which the path is found
    - ``objective``: Objective by which the randomised search measures closure
    - ``seed``: Seed of all random numbers
    - ``timeout``: Stop after this time, seconds, counted from the start of the command [default: no limit]
    - ``bound``: Largest deformation, gap and closure residual that the path may have. Deformation is the change of an
      edge's length over that length. Gap is the distance between the positions that faces give one vertex, over the
      median edge. A note says so if rounding alone may exceed the bound, as for sheets that lie 1e11 edge lengths
      from the origin
    - ``bend``: Largest angle by which panels may bend about their diagonals, degrees. A plan bends panels only if the
      sheet does not fold with rigid ones. Vertices close exactly; the path turns the diagonals, lettered J, and the
      largest bend found is told
    - ``contact``: Depth up to which faces may overlap that touch, in median edges, at most 0.001. Without this option
      it follows from the digits of coordinates and goal angles: 1e-6, and ten times the unit to which they are
      rounded. In front of a small face, at most a thousandth of the face counts
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
    """
    given = dict(locals())
    pattern, jobs, limits = given.pop("pattern"), given.pop("jobs"), given.pop("limits")
    if limits is not None:
        if limit is not None:
            raise FoldpathError("limit, limits: expected one of them, they are the same")
        given["limit"] = limits
    reads = not isinstance(pattern, Pattern)
    if not isinstance(pattern, Pattern):
        reading = {name: given.pop(name) for name in READING}
        pattern = read(pattern, **{name: value for name, value in reading.items() if value is not None})
    with contextlib.ExitStack() as files:
        _store(pattern, given, files)
        answer = _foldpath.plan(pattern._sheet, options(given), reads, threads(jobs), is_forked())
    path = answer.path()
    return Plan(answer.outcome, answer.reason, answer.json, None if path is None else Motion(path))


def _is_file(value: Any) -> bool:
    return isinstance(value, (str, os.PathLike))


def _store(pattern: Pattern, given: dict[str, Any], files: contextlib.ExitStack) -> None:
    """Put goals that are arrays into files, which are there until ``files`` is closed, and limits into a dictionary."""
    edges = len(pattern.edges)

    def stored(angles: Any, name: str) -> File:
        if _is_file(angles):
            named: File = angles
            return named
        file = Path(files.enter_context(tempfile.TemporaryDirectory()), f"{name}.fold")
        told = {**pattern.to_dict(), "edges_foldAngle": degrees(angles, name, edges)}
        file.write_text(to_json(told), encoding="utf-8")
        return file

    if given["goal"] is not None:
        given["goal"] = stored(given["goal"], "goal")
    if given["via"] is not None and not _is_file(given["via"]):
        given["via"] = [stored(angles, f"via{number}") for number, angles in enumerate(given["via"])]
    if isinstance(given["limit"], np.ndarray):
        limits = np.degrees(shaped(given["limit"], "limit", (edges, 2)))
        ends = np.where(np.isnan(limits), [-180.0, 180.0], limits)
        limited = np.flatnonzero(~np.isnan(limits).all(axis=1))
        given["limit"] = {int(edge): tuple(ends[edge]) for edge in limited}
