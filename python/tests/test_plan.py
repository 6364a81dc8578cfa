"""Plans: every option by its name, errors with the text of the command line, the same bytes as the command."""

from __future__ import annotations

import inspect
import json
import os
import pickle
import subprocess
from pathlib import Path

import foldpath as fp
import numpy as np
import pytest
from conftest import Command

PATTERNS = sorted((Path(__file__).parents[2] / "patterns").glob("*.fold"))


def without_times(told: dict) -> dict:
    """Return an answer without what depends on the clock and on who read the file."""
    told = json.loads(json.dumps(told))
    del told["time"]
    for attempt in told["attempts"]:
        del attempt["seconds"]
    return told


@pytest.mark.parametrize("path", PATTERNS, ids=lambda path: path.stem)
def test_answers_and_files_are_those_of_the_command(path: Path, command: Command, tmp_path: Path) -> None:
    files = [tmp_path / name for name in ("command.fold", "python.fold")]
    answer = command("plan", path, "--json", "--timeout", 100, "-o", files[0])
    plan = fp.plan(fp.read(path), timeout=100)
    assert without_times(plan.to_dict()) == without_times(json.loads(answer.out))
    if plan.outcome != "planned":
        assert not files[0].exists()
        return
    assert plan.motion is not None
    plan.motion.save(files[1])
    assert files[0].read_bytes() == files[1].read_bytes()


def test_every_option_of_the_command_is_an_argument() -> None:
    listed = fp.plan(fp.miura(2, 2)).to_dict()["options"]
    arguments = dict(inspect.signature(fp.plan).parameters)
    # Other names of options are not listed.
    del arguments["pattern"], arguments["jobs"], arguments["reuse"], arguments["limits"]
    assert set(arguments) == set(listed)
    for name, argument in arguments.items():
        if argument.default is not None:
            assert argument.default == listed[name], name


def test_options_do_what_they_do_on_the_command_line(command: Command, tmp_path: Path) -> None:
    path = tmp_path / "miura.fold"
    command("generate", "miura", "--rows", 3, "--cols", 3, "-o", path)
    pattern = fp.read(path)
    hinge = int(pattern.hinges[0])
    half = tmp_path / "half.fold"
    command("plan", path, "--fold", 0.5, "-o", half)
    degrees = 20.0 if np.nan_to_num(pattern.goal)[hinge] > 0 else -20.0
    cases: list[tuple[dict, list]] = [
        ({"bound": np.float32(0.5), "seed": np.int64(3)}, ["--bound", 0.5, "--seed", 3]),
        ({"fold": 0.5, "max_accel": 90}, ["--fold", 0.5, "--max-accel", 90]),
        ({"crease": {hinge: degrees}}, ["--crease", f"{hinge}={degrees}"]),
        ({"crease": f"{hinge}={degrees}"}, ["--crease", f"{hinge}={degrees}"]),
        ({"limit": {hinge: (-170, 175.5)}}, ["--limit", f"{hinge}=-170..175.5"]),
        ({"goal": half, "interpolation": "linear"}, ["--goal", half, "--interpolation", "linear"]),
        ({"via": [half], "pace": "sparse"}, ["--via", half, "--pace", "sparse"]),
        ({"via": half}, ["--via", half]),
        ({"symmetry": "off", "vertices": "all", "reuse": "off", "collision": "off"}, ["--symmetry", "off", "--vertices", "all", "--reuse", "off", "--collision", "off"]),
        ({"frames": "angles", "max_knots": 50}, ["--frames", "angles", "--max-knots", 50]),
        ({"solver": "gradient", "contact": 1e-5, "goal_tolerance": 2}, ["--solver", "gradient", "--contact", 1e-5, "--goal-tolerance", 2]),
        ({"search": "random", "objective": "sum", "fold": 0.2, "bound": 0.05}, ["--search", "random", "--objective", "sum", "--fold", 0.2, "--bound", 0.05]),
        ({"jobs": 2, "bend": 1, "max_speed": 30}, ["--jobs", 2, "--bend", 1, "--max-speed", 30]),
    ]
    for number, (options, arguments) in enumerate(cases):
        files = [tmp_path / f"{number}-{name}.fold" for name in ("command", "python")]
        answer = command("plan", path, "--json", "-o", files[0], *arguments)
        plan = fp.plan(path, **options)
        assert answer.out, answer.err
        assert without_times(plan.to_dict()) == without_times(json.loads(answer.out)), options
        assert files[0].exists() == (plan.outcome == "planned")
        if plan.outcome == "planned" and plan.motion is not None:
            plan.motion.save(files[1])
            assert files[0].read_bytes() == files[1].read_bytes(), options


def test_errors_have_the_text_of_the_command_line(command: Command, tmp_path: Path) -> None:
    path = tmp_path / "miura.fold"
    command("generate", "miura", "--rows", 2, "--cols", 2, "-o", path)
    cases: list[tuple[dict, list]] = [
        ({"bound": 0}, ["--bound", 0]),
        ({"bound": float("nan")}, ["--bound", "nan"]),
        ({"max_speed": float("inf")}, ["--max-speed", "inf"]),
        ({"fold": 2}, ["--fold", 2]),
        ({"crease": {0: 30}}, ["--crease", "0=30"]),
        ({"limit": {999: (0, 1)}}, ["--limit", "999=0..1"]),
        ({"goal": tmp_path / "missing.fold"}, ["--goal", tmp_path / "missing.fold"]),
        ({"timeout": -1}, ["--timeout=-1"]),
        ({"tolerance": -1}, ["--tolerance=-1"]),
    ]
    for options, arguments in cases:
        with pytest.raises(fp.FoldpathError) as caught:
            fp.plan(path, **options)
        refused = command("plan", path, *arguments)
        assert refused.status == 2
        assert f"foldpath: {caught.value}" == refused.err.strip(), options
    with pytest.raises(fp.FoldpathError, match="--symmetry: expected auto, off, found on"):
        fp.plan(path, symmetry="on")  # type: ignore[arg-type]
    with pytest.raises(fp.FoldpathError, match="--goal: expected without --fold"):
        fp.plan(path, goal=path, fold=0.5)
    photo = tmp_path / "photo.jpg"
    photo.write_bytes(b"\xff\xd8\xff\xe0")
    with pytest.raises(fp.FoldpathError) as caught:
        fp.plan(photo)
    assert caught.value.hint is not None and "picture of pixels" in caught.value.hint
    with pytest.raises(fp.FoldpathError, match="expected when the pattern is read"):
        fp.plan(fp.read(path), tolerance=0.1)
    with pytest.raises(TypeError):
        fp.plan(path, boud=1)  # type: ignore[call-arg]


def test_a_plan_survives_pickling() -> None:
    plan = fp.plan(fp.miura(2, 3))
    again = pickle.loads(pickle.dumps(plan))
    assert (again.outcome, again.reason) == (plan.outcome, plan.reason)
    assert again.to_dict() == plan.to_dict()
    assert plan.motion is not None and again.motion is not None
    assert np.allclose(again.motion.fold_angles, plan.motion.fold_angles, atol=1e-14, equal_nan=True)


def test_a_no_has_a_reason_and_the_path_as_far_as_it_goes() -> None:
    plan = fp.plan(fp.square_twist(letters="unfoldable"), timeout=30)
    assert plan.outcome != "planned" and plan.reason
    assert plan.reason in repr(plan)
    assert plan.to_dict()["reason"] == plan.reason


def test_edges_and_numbers_of_threads_are_whole_numbers() -> None:
    pattern = fp.miura(3, 3)
    for crease in ({2.9: 30}, {"a": 1}, {4: "x"}):
        with pytest.raises(fp.FoldpathError, match="expected the number of an edge with an angle"):
            fp.plan(pattern, crease=crease)  # type: ignore[arg-type]
    with pytest.raises(fp.FoldpathError, match="lower and an upper angle"):
        fp.plan(pattern, limit={4: (1, 2, 3)})  # type: ignore[dict-item]
    for jobs in (0, -1, 10**30, 2.5):
        with pytest.raises(fp.FoldpathError, match="--jobs: expected a whole number from 1 to 1024"):
            fp.plan(pattern, jobs=jobs)  # type: ignore[arg-type]


def test_time_out_holds_for_reading_as_well(tmp_path: Path) -> None:
    """A pattern arrives slowly, and is planned a hundred times faster than the timeout."""
    _, source, _ = fp.miura(3, 3)._sheet.source()
    (tmp_path / "ready.fold").write_bytes(source)
    slow = tmp_path / "slow.fold"
    os.mkfifo(slow)
    with subprocess.Popen(["sh", "-c", "sleep 0.6; cat ready.fold > slow.fold"], cwd=tmp_path):
        assert fp.plan(slow, timeout=0.5).outcome == "timeout"
    assert fp.plan(tmp_path / "ready.fold", timeout=0.5).outcome == "planned"


def test_goals_and_limits_are_arrays_as_well_as_files() -> None:
    pattern = fp.miura(3, 3, fold=0.8)
    hinges = pattern.hinges
    whole = fp.plan(pattern).motion
    assert whole is not None and np.array_equal(whole.hinges, hinges)
    assert np.array_equal(whole.pattern.vertices, pattern.vertices)
    half = whole.fold_angles[-1].copy()
    half[hinges] = whole.at(whole.duration / 2)[hinges]
    planned = fp.plan(pattern, goal=half)
    assert planned.outcome == "planned" and planned.motion is not None
    assert np.allclose(planned.motion.fold_angles[-1][hinges], half[hinges], rtol=0, atol=1e-6)
    # One hinge is driven, and the others are free.
    driven = np.full(len(pattern.edges), np.nan)
    driven[hinges[0]] = half[hinges[0]]
    planned = fp.plan(pattern, goal=driven)
    assert planned.outcome == "planned" and planned.motion is not None
    assert np.allclose(planned.motion.fold_angles[-1][hinges], half[hinges], rtol=0, atol=1e-6)
    there_and_back = fp.plan(pattern, fold=0, via=[whole.fold_angles[-1]])
    assert there_and_back.outcome == "planned" and there_and_back.motion is not None
    assert np.nanmax(np.abs(there_and_back.motion.fold_angles)) > 2
    limits = np.full((len(pattern.edges), 2), np.nan)
    limits[hinges[0]] = np.radians([-30, 30])
    limited = fp.plan(pattern, limit=limits)
    assert limited.outcome != "planned"
    assert fp.plan(pattern, limits=limits).to_dict()["options"]["limit"] == limited.to_dict()["options"]["limit"]
    with pytest.raises(fp.FoldpathError, match="limit, limits: expected one of them"):
        fp.plan(pattern, limit=limits, limits=limits)
    with pytest.raises(fp.FoldpathError, match="goal: expected the shape"):
        fp.plan(pattern, goal=half[1:])
    with pytest.raises(fp.FoldpathError, match="goal: expected finite angles or nan"):
        fp.plan(pattern, goal=np.where(np.isnan(half), np.inf, half))
