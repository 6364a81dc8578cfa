"""Plans."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal, Union

from . import _foldpath
from ._convert import File, edges_with, is_forked, options, threads
from ._motion import Motion
from ._pattern import Pattern, Source, Straighten, read

OnOff = Literal["on", "off"]
AutoOff = Literal["auto", "off"]


class Plan:
    """The answer to :func:`plan`."""

    __slots__ = ("_json", "_motion", "_outcome", "_reason")
    _outcome: str
    _reason: str | None
    # The text of the answer is made when it is asked for, as it takes about as long as a small plan.
    _json: Callable[[], str]
    _motion: Motion | None

    def __init__(
        self, outcome: str, reason: str | None, json: Callable[[], str], motion: Motion | None
    ) -> None:
        self._outcome = outcome
        self._reason = reason
        self._json = json
        self._motion = motion

    @property
    def outcome(self) -> str:
        """``planned`` if the goal is reached and everything asked is proved; else why not, in a word."""
        return self._outcome

    @property
    def reason(self) -> str | None:
        """Why the outcome is not ``planned``, in a sentence."""
        return self._reason

    @property
    def motion(self) -> Motion | None:
        """The motion as far as it goes; ``None`` if none was found.

        Only if the outcome is ``planned`` does it reach the goal.
        """
        return self._motion

    def to_dict(self) -> dict[str, Any]:
        """Return the object of ``foldpath plan --json``."""
        told: dict[str, Any] = json.loads(self._json())
        return told

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self._outcome, self._reason, self._json(), self._motion)

    def __repr__(self) -> str:
        reason = f": {self.reason}" if self.reason else ""
        return f"<foldpath.Plan {self.outcome}{reason}>"


def _again(outcome: str, reason: str | None, text: str, motion: Motion | None) -> Plan:
    """Make an answer again that was pickled."""
    return Plan(outcome, reason, lambda: text, motion)


def plan(
    pattern: Union[Pattern, Source],
    *,
    goal: File | None = None,
    fold: float | None = None,
    crease: Mapping[int, float] | Iterable[str] | str | None = None,
    via: Iterable[File] | File | None = None,
    goal_tolerance: float = 1.0,
    limit: Mapping[int, tuple[float, float]] | Iterable[str] | str | None = None,
    bound: float = 0.01,
    bend: float = 0.0,
    keep: bool = False,
    contact: float | None = None,
    symmetry: AutoOff = "auto",
    vertices: Literal["essential", "all"] = "essential",
    reuse: AutoOff | None = None,
    collision: OnOff = "on",
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
    tolerance: float | None = None,
    straighten: Straighten | None = None,
    colors: str | None = None,
    jobs: int | None = None,
) -> Plan:
    """Find a path from the flat sheet to a goal.

    Every option is that of ``foldpath plan``, by its name and in its units: degrees and seconds. ``crease`` may be a
    dictionary from edges to degrees, ``limit`` one from edges to ranges of degrees. ``tolerance``, ``straighten`` and
    ``colors`` are for patterns that are yet to be read. ``keep`` changes nothing here: ``motion`` is always the path as
    far as it goes.

    The interpreter's lock is released, and Ctrl-C ends the plan. ``jobs`` threads share the work; by default one for each
    core, and one in a process that was forked.

    Raises :class:`FoldpathError`, a ``ValueError`` with the text of the command line, for bad input or options. An answer
    without a motion is an outcome, not an error.
    """
    given: dict[str, Any] = {
        "goal": goal,
        "fold": fold,
        "crease": edges_with(crease),
        "via": via if via is None or isinstance(via, (str, bytes)) else _list(via),
        "goal_tolerance": goal_tolerance,
        "limit": edges_with(limit),
        "bound": bound,
        "bend": bend,
        "keep": keep,
        "contact": contact,
        "symmetry": symmetry,
        "vertices": vertices,
        "reuse": reuse,
        "collision": collision,
        "interpolation": interpolation,
        "max_speed": max_speed,
        "max_accel": max_accel,
        "pace": pace,
        "max_knots": max_knots,
        "frames": frames,
        "solver": solver,
        "search": search,
        "objective": objective,
        "seed": seed,
        "timeout": timeout,
    }
    reads = False
    reading = {"tolerance": tolerance, "straighten": straighten, "colors": colors}
    if isinstance(pattern, Pattern):
        given.update(reading)
    else:
        known: dict[str, Any] = {name: value for name, value in reading.items() if value is not None}
        pattern = read(pattern, **known)
        reads = True
    answer = _foldpath.plan(pattern._sheet, options(given), reads, threads(jobs), is_forked())
    path = answer.path()
    return Plan(answer.outcome, answer.reason, answer.json, None if path is None else Motion(path))


def _list(via: Any) -> list[File]:
    return [via] if hasattr(via, "__fspath__") else list(via)
