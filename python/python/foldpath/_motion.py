"""Motions: evaluating, judging, showing and exporting them."""

from __future__ import annotations

import html
import json
import operator
import os
from collections.abc import Mapping
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _foldpath
from ._answer import Answer
from ._convert import File, Floats, Integers, contiguous, floats, integers, is_forked, options, shaped, threads
from ._error import FoldpathError
from ._pattern import Pattern, Source, content

Format = Literal["traj", "csv", "rust", "obj", "glb", "svg", "dxf", "stl", "mjcf", "joint-trajectory", "ros2-control"]

#: Acceleration of free fall in the frame of the drawing, metres per second squared.
GRAVITY = (0.0, 0.0, -9.80665)


class Motion:
    """The motion of a sheet from flat to its goal.

    ``K`` is the number of knots, which are stored configurations, ``E`` that of edges and ``V`` that of vertices. Times
    are in seconds, fold angles in radians, valley positive.
    """

    __slots__ = ("_path",)
    _path: _foldpath.Path

    def __init__(self, path: _foldpath.Path) -> None:
        self._path = path

    @property
    def title(self) -> str:
        """The title."""
        return self._path.title

    @property
    def times(self) -> Floats:
        """Times of the knots: (K,)."""
        return floats(self._path.times(), -1)

    @property
    def duration(self) -> float:
        """Time of the last knot."""
        return float(self.times[-1])

    @property
    def fold_angles(self) -> Floats:
        """Fold angles of the edges at the knots: (K, E), nan for edges that are no hinge."""
        return floats(self._path.fold_angles(), self._path.knots, self._path.edge_count)

    @property
    def rates(self) -> Floats:
        """Angular speeds of the edges at the knots, radians per second: (K, E), nan for edges that are no hinge.

        They are those of :meth:`rates_at`.
        """
        return self.rates_at(self.times)

    @property
    def groups(self) -> Integers:
        """Crease group of each edge: (E,), -1 for edges that are no hinge.

        Creases of a group have the same angle all along the motion, but for :attr:`signs`.
        """
        groups: Integers = np.nan_to_num(floats(self._path.groups(), 2, -1)[0], nan=-1.0).astype(np.int64)
        return groups

    @property
    def signs(self) -> Integers:
        """Sign of each edge in its crease group: (E,), 1 or -1, and 0 for edges that are no hinge."""
        signs: Integers = np.nan_to_num(floats(self._path.groups(), 2, -1)[1]).astype(np.int64)
        return signs

    @property
    def pattern(self) -> Pattern:
        """The crease pattern of the sheet."""
        return Pattern._of(_foldpath.Sheet.parse(self._path.file, self._path.text().encode(), "{}"))

    @property
    def hinges(self) -> Integers:
        """Numbers of the edges that are hinges."""
        return np.flatnonzero(~np.isnan(self.fold_angles[0])).astype(np.int64)

    @property
    def edges(self) -> Integers:
        """Vertices of the edges: (E, 2)."""
        return integers(self._path.edges(), -1, 2)

    @property
    def faces(self) -> list[list[int]]:
        """Vertices of each panel, counter-clockwise."""
        return self._path.faces()

    def at(self, t: ArrayLike) -> Floats:
        """Return the fold angles at a time, (E,), or at times, (T, E); before the start and after the end it rests."""
        times = contiguous(t, "t")
        _check_times(times)
        angles = self._path.at(times.tobytes())
        return floats(angles, *times.shape, self._path.edge_count)

    def rates_at(self, t: ArrayLike) -> Floats:
        """Return the angular speeds of the edges at a time, (E,), or at times, (T, E), radians per second.

        They are derivatives of the curves that the angles follow. At a knot they are those of the segment after it, and at the
        last knot those of the segment before; before the start and after the end the sheet rests.
        """
        times = contiguous(t, "t")
        _check_times(times)
        rates = self._path.rates(times.tobytes())
        return floats(rates, *times.shape, self._path.edge_count)

    def vertices(self, t: ArrayLike) -> Floats:
        """Return the positions of the vertices at a time, (V, 3), or at times, (T, V, 3).

        A panel in the middle of the sheet stays where it is drawn.
        """
        times = contiguous(t, "t")
        _check_times(times)
        positions = self._path.vertices(times.tobytes())
        return floats(positions, *times.shape, self._path.vertex_count, 3)

    def save(self, file: File) -> None:
        """Write the path file, a FOLD animation. It is written whole or not at all."""
        self._path.save(file)

    def page(
        self,
        *,
        error: float | None = None,
        play: float | None = None,
        areal_density: float | None = None,
        **load: Any,
    ) -> str:
        """Return the interactive page, in HTML that needs no network.

        With ``error`` or ``play``, as in :func:`tolerance`, hinges are coloured by the play that they need. With
        ``areal_density`` the page has the torques of the drivers; ``load`` may have ``fixed``, ``gravity``, ``spring`` and ``unit``
        of :func:`loads`.
        """
        return self._path.page(error, play, _load_if_given(self, areal_density, load), is_forked())

    def save_page(self, file: File, **given: Any) -> None:
        """Write the interactive page; see :meth:`page` for the arguments."""
        _foldpath.write_text(file, self.page(**given))

    def plot(self, *, areal_density: float | None = None, **load: Any) -> str:
        """Return a picture of the curves along the motion, as SVG: angles, deformation, gap and clearance.

        With ``areal_density`` it has the torques of the drivers as well; ``load`` may have ``fixed``, ``gravity``, ``spring`` and
        ``unit`` of :func:`loads`.
        """
        return self._path.plot(_load_if_given(self, areal_density, load), is_forked())

    def save_plot(self, file: File, **given: Any) -> None:
        """Write the picture of the curves, an SVG file; see :meth:`plot`. ``foldpath plot`` writes PNG files too."""
        if not os.fsdecode(file).lower().endswith(".svg"):
            raise FoldpathError(f"{os.fsdecode(file)}: expected a name that ends in .svg")
        _foldpath.write_text(file, self.plot(**given))

    def export(
        self,
        file: File,
        to: Format,
        *,
        rate: float | None = None,
        per: Literal["hinge", "group"] | None = None,
        frames: int | None = None,
        colour: Literal["letters", "groups", "deformation", "plates"] | None = None,
        assembled: bool | None = None,
        kerf: float | None = None,
        density: float | None = None,
        joints: Literal["all", "drivers"] | None = None,
        names: File | ArrayLike | None = None,
        numbers: bool | None = None,
        bound: float | None = None,
        resolution: float | None = None,
        period: float | None = None,
        delay: float | None = None,
        brake: float | None = None,
        unit: Literal["nm", "um", "mm", "cm", "m", "in", "pt"] | None = None,
    ) -> None:
        """Export the motion, as ``foldpath export`` does.

        The formats:

        - ``traj``: File that a controller stores and follows: group angles and rates at the knots, with limits
        - ``csv``: One row for each knot, or at a fixed rate: time in seconds and fold angles in degrees
        - ``rust``: Contents of a .traj file as Rust constants, which need foldpath-core but no std
        - ``obj``: Sequence of Wavefront OBJ files, one for each frame; ``file`` is a folder, or the beginning of the names
        - ``glb``: Binary glTF 2.0 with the motion as an animation
        - ``svg``: Coloured drawing of the crease pattern
        - ``dxf``: Drawing of the flat sheet for CAD programs and laser cutters, with a layer for each fold side; of plates, their outlines
        - ``stl``: Plates for printers and mills: a folder with a file for each form, in millimetres, and a list with their numbers; ``file`` is a folder
        - ``mjcf``: Model for MuJoCo and Drake: a folder with scene.xml and a mesh for each panel; ``file`` is a folder
        - ``joint-trajectory``: ROS's trajectory_msgs/JointTrajectory in YAML: a joint for each hinge
        - ``ros2-control``: Parameters of ros2_control in YAML: a controller that follows the trajectories of --to joint-trajectory

        The options:

        - ``rate``: With csv: rows a second, and one for the end [default: a row for each knot]. The first column is
          the time t in seconds; angles are in degrees, valley positive
        - ``per``: With csv and ``rate``: what has a column
        - ``frames``: With obj or glb: number of frames, 2 to 2000, evenly spaced in time. By default obj has one
          frame for each knot. By default glb also has frames between the knots, so that no hinge turns by more than 6
          degrees from one frame to the next
        - ``colour``: With svg: meaning of the colours
        - ``assembled``: With stl: one file with all plates, folded as at the end of the path
        - ``kerf``: With dxf, or svg and ``colour`` plates: width of the cut, by half of which outlines are larger, in
          the drawing's unit
        - ``density``: With mjcf: density of the panels, kilograms per cubic metre. Without it masses are in
          proportion to the size of the sheet
        - ``joints``: With joint-trajectory or ros2-control: hinges that are joints
        - ``names``: With joint-trajectory or ros2-control: names of the joints, a line for each hinge in the order of
          the edges. By default the hinge at edge I is crease_I. There is a name for every hinge, also if `--joints
          drivers` leaves most of them out
        - ``numbers``: With svg: write the number of each edge at its middle, as ``crease`` and ``limit`` count them
        - ``bound``: With traj or rust: slow the path down, so that a hinge that sticks tears the sheet by no more
          than this gap. The gap is the distance between the positions that faces give one vertex, over the median
          edge, once the controller has noticed and the motion rests. The file tells the controller the lag from which
          on it has to hold. Drives that are too coarse for the bound are an error. Without a bound the speed stays
        - ``resolution``: With traj or rust: largest angle by which a drive is off its command at rest, or measured
          there, degrees
        - ``period``: With traj or rust: longest time between two measurements of a hinge, seconds
        - ``delay``: With traj or rust: time by which drives follow late, seconds
        - ``brake``: With traj or rust: loss of the speed in a second when the controller brakes, in full speeds
        - ``unit``: Unit of the lengths of a file that names none. A unit that differs from that of the file is an
          error. Places, lengths, paths and models have the unit of the file
        """
        given = dict(locals())
        arguments = [f"--output={os.fsdecode(given.pop('file'))}"]
        del given["self"]
        arguments += [f"--{name}={value}" for name, value in given.items() if value is not None]
        self._path.export(arguments)

    def check(self, *, jobs: int | None = None, **given: Any) -> Verdict:
        """Judge the motion; see :func:`check` for the options."""
        return check(self, jobs=jobs, **given)

    def drivers(self, t: float) -> list[int]:
        """Return the edges of hinges whose angles determine all others at a time: the drivers of :meth:`jvp`."""
        return self._path.drivers(float(t))

    def jvp(
        self, t: float, vertices: ArrayLike | None = None, drivers: ArrayLike | None = None
    ) -> tuple[Floats, Floats]:
        """Return rates of fold angles, (E,), and of folded vertices, (V, 3), at a time.

        ``vertices`` has the change of each vertex of the flat pattern, (V, 2), and ``drivers`` that of the angle of each of
        :meth:`drivers`, radians, (D,); those left out are zero. Many changes at once, (N, V, 2) and (N, D), have rates (N, E)
        and (N, V, 3), and cost little more than one. The panel in the middle of the sheet keeps its place. Rates are nan for
        edges that are no hinge. The configuration is the closed one nearest to the motion.

        Raises :class:`FoldpathError` at singular configurations, as flat, and for changes with which the sheet does not fold.
        """
        count = self._path.vertex_count
        both = (vertices, "vertices", (count, 2)), (drivers, "drivers", (len(self.drivers(t)),))
        many, (changes, driven) = _stacked(*both)
        angles, places = self._path.jvp(float(t), changes.tobytes(), driven.tobytes())
        return floats(angles, *many, self._path.edge_count), floats(places, *many, count, 3)

    def vjp(
        self, t: float, angles: ArrayLike | None = None, vertices: ArrayLike | None = None
    ) -> tuple[Floats, Floats]:
        """Return the gradient by the vertices of the flat pattern, (V, 2), and by the drivers' angles, (D,), at a time.

        ``angles`` has the gradient by the fold angle of each edge, (E,), of which those of edges that are no hinge count for
        nothing, and ``vertices`` that by the folded vertices, (V, 3); those left out are zero. Many at once, (N, E) and
        (N, V, 3), have gradients (N, V, 2) and (N, D), and cost little more than one. The gradient holds for changes with
        which the pattern still folds.

        Raises :class:`FoldpathError` at singular configurations.
        """
        count = self._path.vertex_count
        both = (angles, "angles", (self._path.edge_count,)), (vertices, "vertices", (count, 3))
        many, (by_angles, by_vertices) = _stacked(*both)
        flat, drivers = self._path.vjp(float(t), by_angles.tobytes(), by_vertices.tobytes())
        size = len(drivers) // 8 // (many[0] if many else 1)
        return floats(flat, *many, count, 2), floats(drivers, *many, size)

    def _repr_html_(self) -> str:
        page = html.escape(self.page())
        style = "width: 100%; height: 640px; border: 0"
        return f'<iframe title="{html.escape(self.title)}" srcdoc="{page}" style="{style}"></iframe>'

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self._path.file, self._path.text())

    def __repr__(self) -> str:
        return f"<foldpath.Motion {self.title!r}: {self._path.knots} knots, {self.duration:.3f} s>"


def _stacked(
    *given: tuple[ArrayLike | None, str, tuple[int, ...]],
) -> tuple[tuple[int, ...], list[Floats]]:
    """Return arrays of these shapes, or of as many of them, with zeros for those left out; and how many, if there are several."""
    arrays = [None if values is None else contiguous(values, name) for values, name, _ in given]
    shapes = [array.shape for array, (_, _, shape) in zip(arrays, given) if array is not None and array.ndim > len(shape)]
    many = shapes[0][:1] if shapes else ()
    full = [(*many, *shape) for _, _, shape in given]
    return many, [
        np.zeros(shape) if array is None else shaped(array, name, shape)
        for array, (_, name, _), shape in zip(arrays, given, full)
    ]


def _check_times(times: Floats) -> None:
    if times.ndim > 1:
        raise FoldpathError(f"t: expected a time or one dimension of times, found {times.ndim}")
    if not np.isfinite(times).all():
        raise FoldpathError("t: expected finite times, found infinity or nan")


def _again(name: str, text: str) -> Motion:
    """Make a motion again that was pickled."""
    return Motion(_foldpath.Path.parse(name, text.encode()))


def load(source: Source) -> Motion:
    """Read a motion from a path file, its bytes, an open binary file, or a dictionary in the form of FOLD."""
    if isinstance(source, (str, os.PathLike)):
        return Motion(_foldpath.Path.read(source))
    return Motion(_foldpath.Path.parse("<bytes>", content(source)))


class Verdict(Answer):
    """A verdict on a motion: the outcome is ``holds``, ``fails`` or ``undecided``."""

    __slots__ = ()


def check(
    motion: Union[Motion, Source],
    *,
    timeout: float | None = None,
    bound: float = 0.01,
    bend: float = 0.0,
    contact: float | None = None,
    jobs: int | None = None,
) -> Verdict:
    """Judge a motion afresh, or a path file: rigidity, closure, signs and crossings, at the knots and between them.

    The options:

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
    """
    given = dict(locals())
    motion, jobs = given.pop("motion"), given.pop("jobs")
    if not isinstance(motion, Motion):
        motion = load(motion)
    return Verdict._of(motion._path.check(options(given), threads(jobs), is_forked()))


def tolerance(
    motion: Union[Motion, Source],
    error: float | None = None,
    *,
    play: float | None = None,
    timeout: float | None = None,
    jobs: int | None = None,
) -> dict[str, Any]:
    """Tell how exactly a sheet has to be made: the object of ``foldpath tolerance --json``.

    ``error`` is the largest error of each coordinate of each vertex, in the file's unit. With ``play`` in its place, the
    answer has the error that this play allows. ``timeout`` is in seconds: :class:`FoldpathError` is raised when it is over.
    """
    if not isinstance(motion, Motion):
        motion = load(motion)
    told = motion._path.tolerance(error, play, timeout, threads(jobs), is_forked())
    answer: dict[str, Any] = json.loads(told)
    return answer


def loads(
    motion: Union[Motion, Source],
    areal_density: float,
    *,
    fixed: int | None = None,
    gravity: tuple[float, float, float] = GRAVITY,
    spring: float | Mapping[int, float] | ArrayLike = 0.0,
    drivers: int | None = None,
    drives: File | list[tuple[str, float, float]] | None = None,
    unit: Literal["nm", "um", "mm", "cm", "m", "in", "pt"] | None = None,
    timeout: float | None = None,
    jobs: int | None = None,
) -> dict[str, Any]:
    """Tell how strong the drives of a sheet have to be: the object of ``foldpath loads --json``.

    ``areal_density`` is in kilograms per square metre, ``gravity`` in metres per second squared in the frame of the drawing
    with face ``fixed`` in its place, ``spring`` in newton metres per radian: of each hinge, or
    of single ones in a dictionary from edges, or an array with that of each edge, (E,), nan where there is none. ``drivers`` is the number of drivers, at least
    the degrees of freedom; more share the load with the least sum of squares. ``drives`` has name, stall torque (newton
    metres) and speed without load (degrees per second) of each kind of drive, or is a file of such lines. ``unit`` is the unit of lengths, if the file
    tells none. After ``timeout`` seconds the best set of drivers found by then is told; :class:`FoldpathError` is raised if there
    is none.
    """
    if not isinstance(motion, Motion):
        motion = load(motion)
    weight = _load(motion, areal_density, fixed=fixed, gravity=gravity, spring=spring, unit=unit)
    kinds = _foldpath.read_drives(drives) if isinstance(drives, (str, os.PathLike)) else drives or []
    told = motion._path.loads(weight, drivers, kinds, timeout, threads(jobs), is_forked())
    answer: dict[str, Any] = json.loads(told)
    return answer


def _load(
    motion: Motion,
    areal_density: float,
    *,
    fixed: int | None = None,
    gravity: tuple[float, float, float] = GRAVITY,
    spring: float | Mapping[int, float] | ArrayLike = 0.0,
    unit: str | None = None,
) -> dict[str, Any]:
    """Return a load as the extension module takes it; see :func:`loads`."""
    everywhere, single = 0.0, []
    if isinstance(spring, Mapping):
        single = [(operator.index(edge), float(stiffness)) for edge, stiffness in spring.items()]
    elif np.ndim(spring):
        stiffness = shaped(spring, "spring", (motion._path.edge_count,))
        single = [(int(edge), float(stiffness[edge])) for edge in np.flatnonzero(~np.isnan(stiffness))]
    else:
        everywhere = float(spring)  # type: ignore[arg-type]
    return {
        "areal_density": float(areal_density),
        "fixed": fixed,
        "gravity": shaped(gravity, "gravity", (3,)).tolist(),
        "spring": everywhere,
        "springs": single,
        "unit": unit,
    }


def _load_if_given(motion: Motion, areal_density: float | None, given: dict[str, Any]) -> dict[str, Any] | None:
    """Return a load as the extension module takes it, or None without a mass."""
    if areal_density is not None:
        return _load(motion, areal_density, **given)
    if given:
        raise FoldpathError(f"{next(iter(given))}: expected with areal_density")
    return None
