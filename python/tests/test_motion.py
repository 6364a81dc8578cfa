"""Motions: arrays, files, judging, showing and exporting."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import foldpath as fp
import numpy as np
import pytest
from conftest import Command


@pytest.fixture(scope="module")
def motion() -> fp.Motion:
    found = fp.plan(fp.miura(4, 5)).motion
    assert found is not None
    return found


@pytest.fixture(scope="module")
def loaded(motion: fp.Motion, tmp_path_factory: pytest.TempPathFactory) -> tuple[fp.Motion, Path]:
    """Return a motion that was read from its file, and the file.

    Angles are degrees in files, so that the last digit of radians may change when a motion is saved and read.
    """
    path = tmp_path_factory.mktemp("motion") / "path.fold"
    motion.save(path)
    return fp.load(path), path


def test_arrays_are_those_of_the_path_file(motion: fp.Motion, tmp_path: Path) -> None:
    path = tmp_path / "path.fold"
    motion.save(path)
    file = json.loads(path.read_text())
    frames = [frame for frame in file["file_frames"] if "foldedForm" in frame["frame_classes"]]
    assert len(frames) == len(motion.times)
    assert motion.edges.tolist() == file["edges_vertices"]
    assert motion.faces == file["faces_vertices"]
    for knot, frame in enumerate(frames):
        # Edges that are no hinge have angle 0 in the file.
        ours = np.degrees(np.nan_to_num(motion.fold_angles[knot]))
        assert np.allclose(ours, frame["edges_foldAngle"], atol=1e-12)
        positions = motion.vertices(motion.times[knot])
        assert np.allclose(positions, frame["vertices_coords"], atol=1e-12)


def test_a_motion_is_evaluated_at_one_time_and_at_many(motion: fp.Motion) -> None:
    times = np.linspace(-1, motion.duration + 1, 7)
    many, shapes = motion.at(times), motion.vertices(times)
    edges, vertices = len(motion.edges), shapes.shape[1]
    assert many.shape == (7, edges) and shapes.shape == (7, vertices, 3)
    for number, time in enumerate(times):
        assert motion.at(time).shape == (edges,)
        assert np.array_equal(motion.at(time), many[number], equal_nan=True)
        assert np.array_equal(motion.vertices(float(time)), shapes[number])
    assert np.array_equal(motion.at(motion.times), motion.fold_angles, equal_nan=True)
    # At rest before the start and after the end.
    assert np.array_equal(many[0], motion.fold_angles[0], equal_nan=True)
    assert np.array_equal(many[-1], motion.fold_angles[-1], equal_nan=True)
    # Panels stay rigid: no edge changes its length between knots.
    a, b = motion.edges.T
    lengths = np.linalg.norm(shapes[:, a] - shapes[:, b], axis=2)
    assert np.abs(lengths / lengths[0] - 1).max() < 1e-12
    for wrong in ([[0.0]], np.nan):
        with pytest.raises(fp.FoldpathError):
            motion.at(wrong)
    assert motion.at([]).shape == (0, edges)
    assert motion.at(np.float32(0.5)).shape == (edges,)


@pytest.mark.parametrize("interpolation", ["half-angle", "hermite", "homogeneous", "linear"])
def test_rates_are_derivatives_of_the_angles(interpolation: Any) -> None:
    motion = fp.plan(fp.miura(3, 3), interpolation=interpolation).motion
    assert motion is not None
    between = (motion.times[1:] + motion.times[:-1]) / 2
    step = 1e-6
    differences = (motion.at(between + step) - motion.at(between - step)) / (2 * step)
    rates = motion.rates_at(between)
    assert np.nanmax(np.abs(rates - differences)) < 1e-7 and np.nanmax(np.abs(rates)) > 0.5
    assert np.array_equal(motion.rates_at(between[0]), rates[0], equal_nan=True)
    # At the knots: of the segment after each, and at the last one of the segment before.
    after = (motion.at(motion.times[:-1] + step) - motion.fold_angles[:-1]) / step
    before = (motion.fold_angles[-1] - motion.at(motion.duration - step)) / step
    assert np.nanmax(np.abs(motion.rates - np.vstack([after, before]))) < 1e-4
    assert np.array_equal(np.isnan(motion.rates), np.isnan(motion.fold_angles))
    # At rest before the start and after the end.
    assert np.nanmax(np.abs(motion.rates_at([-1.0, motion.duration + 1]))) == 0
    with pytest.raises(fp.FoldpathError, match="expected finite times"):
        motion.rates_at(np.inf)


def test_creases_of_a_group_have_one_angle(motion: fp.Motion) -> None:
    groups, signs = motion.groups, motion.signs
    rest = np.isnan(motion.fold_angles[0])
    assert groups.shape == (len(motion.edges),) and groups.dtype == np.int64
    assert (groups[rest] == -1).all() and (signs[rest] == 0).all()
    assert set(groups[~rest]) == set(range(groups.max() + 1)) and set(signs[~rest]) == {-1, 1}
    # A Miura has two groups.
    assert groups.max() == 1
    for group in range(2):
        (members,) = np.nonzero(groups == group)
        angles = motion.fold_angles[:, members] * signs[members]
        assert np.abs(angles - angles[:, :1]).max() == 0


def test_arrays_own_their_memory(motion: fp.Motion) -> None:
    angles = motion.fold_angles
    angles[:] = 0
    assert np.nanmax(np.abs(motion.fold_angles)) > 1


def test_a_motion_survives_saving_loading_and_pickling(
    motion: fp.Motion, loaded: tuple[fp.Motion, Path], tmp_path: Path
) -> None:
    again, path = loaded
    for same in (again, fp.load(path.read_bytes()), pickle.loads(pickle.dumps(motion))):
        assert np.allclose(same.fold_angles, motion.fold_angles, rtol=0, atol=1e-15, equal_nan=True)
        assert np.array_equal(same.fold_angles, again.fold_angles, equal_nan=True)
        assert np.array_equal(same.times, motion.times)
    with pytest.raises(fp.FoldpathError, match="no/such: "):
        motion.save(tmp_path / "no/such")


def test_the_verdict_is_that_of_the_command(
    motion: fp.Motion, loaded: tuple[fp.Motion, Path], command: Command
) -> None:
    again, path = loaded
    answer = command("check", path, "--json")
    verdict = fp.check(again)
    assert verdict.outcome == "holds" and verdict.reason is None
    assert verdict.to_dict() == json.loads(answer.out)
    assert motion.check().outcome == "holds"
    assert fp.check(path, jobs=2).to_dict() == verdict.to_dict()
    strict = fp.check(motion, bound=1e-16)
    assert strict.outcome != "holds" and strict.reason
    with pytest.raises(fp.FoldpathError, match="--bound: expected a fraction above 0 and at most 1, found -1"):
        motion.check(bound=-1)


def test_a_notebook_shows_the_interactive_page(
    loaded: tuple[fp.Motion, Path], command: Command, tmp_path: Path
) -> None:
    (motion, path), page = loaded, tmp_path / "page.html"
    assert command("view", path, "-o", page).status == 0
    assert motion.page() == page.read_text()
    motion.save_page(tmp_path / "python.html")
    assert (tmp_path / "python.html").read_bytes() == page.read_bytes()
    shown = motion._repr_html_()
    assert shown.startswith("<iframe") and "srcdoc=" in shown
    # Nothing of the page ends the attribute.
    srcdoc = shown.split('srcdoc="')[1]
    assert srcdoc.index('"') == srcdoc.index('" style=')


@pytest.mark.parametrize("to", ["traj", "csv", "rust", "glb", "svg", "joint-trajectory", "obj", "mjcf"])
def test_exports_are_those_of_the_command(
    to: str, motion: fp.Motion, loaded: tuple[fp.Motion, Path], command: Command, tmp_path: Path
) -> None:
    again, path = loaded
    if to != "svg":
        # The drawing shows the goal, which a motion that was read has not. Other formats show the last digit of angles.
        motion = again
    files = [tmp_path / name for name in ("command", "python")]
    several = to in ("obj", "mjcf")
    for file in files:
        if several:
            file.mkdir()
    assert command("export", path, "--to", to, "-o", files[0]).status == 0
    motion.export(files[1], to)  # type: ignore[arg-type]
    if several:
        names = [sorted(found.name for found in file.iterdir()) for file in files]
        assert names[0] == names[1] and names[0]
        pairs = [(files[0] / name, files[1] / name) for name in names[0]]
    else:
        pairs = [(files[0], files[1])]
    for theirs, ours in pairs:
        assert theirs.read_bytes() == ours.read_bytes()


def test_options_of_exports(motion: fp.Motion, tmp_path: Path) -> None:
    file = tmp_path / "out.csv"
    motion.export(file, "csv", rate=10, per="group")
    assert file.read_text().startswith("t,group_0")
    with pytest.raises(fp.FoldpathError, match="--rate: expected --to csv, found --to glb"):
        motion.export(file, "glb", rate=10)
    with pytest.raises(fp.FoldpathError, match="expected a name that ends in .svg"):
        motion.save_plot(tmp_path / "curves.png")
    with pytest.raises(fp.FoldpathError, match="invalid value 'step'"):
        motion.export(file, "step")  # type: ignore[arg-type]


def test_a_path_without_a_unit_is_exported_in_one(
    loaded: tuple[fp.Motion, Path], command: Command, tmp_path: Path
) -> None:
    motion, path = loaded
    texts = []
    for unit in ("mm", "in"):
        ours, theirs = tmp_path / f"{unit}.dxf", tmp_path / f"{unit}-command.dxf"
        motion.export(ours, "dxf", unit=unit)  # type: ignore[arg-type]
        assert command("export", path, "--to=dxf", f"--unit={unit}", "-o", theirs).status == 0
        assert ours.read_bytes() == theirs.read_bytes()
        texts.append(ours.read_text())
    assert texts[0] != texts[1]


def test_curves_are_those_of_the_command(
    loaded: tuple[fp.Motion, Path], command: Command, tmp_path: Path
) -> None:
    (motion, path), plot = loaded, tmp_path / "plot.svg"
    assert command("plot", path, "-o", plot).status == 0
    assert motion.plot() == plot.read_text()


def test_page_and_curves_have_play_and_torques_if_they_are_asked_for(
    loaded: tuple[fp.Motion, Path], command: Command, tmp_path: Path
) -> None:
    (motion, path), made = loaded, tmp_path / "made.svg"
    hinge = int(motion.hinges[0])
    load: dict[str, Any] = {"areal_density": 0.8, "unit": "mm", "spring": {hinge: 0.02}, "gravity": (0.0, -9.81, 0.0)}
    flags = "--areal-density=0.8", "--unit=mm", f"--spring={hinge}=0.02", "--gravity=0,-9.81,0"
    assert command("plot", path, "-o", made, *flags).status == 0
    assert motion.plot(**load) == made.read_text() != motion.plot()
    motion.save_plot(tmp_path / "python.svg", **load)
    assert (tmp_path / "python.svg").read_text() == made.read_text()
    assert command("view", path, "-o", made, "--error=0.001", *flags).status == 0
    assert motion.page(error=0.001, **load) == made.read_text()
    assert command("view", path, "-o", made, "--play=0.001").status == 0
    motion.save_page(tmp_path / "python.html", play=0.001)
    assert (tmp_path / "python.html").read_text() == made.read_text() != motion.page()
    for call, text in (
        (lambda: motion.plot(spring=1.0), "spring: expected with areal_density"),
        (lambda: motion.page(areal_density=-1.0), "areal_density: expected a number from 0"),
        (lambda: motion.page(areal_density=1.0), "unit of length"),
        (lambda: motion.plot(areal_density=1.0, gravity=(0.0, 1.0)), "gravity: expected the shape"),
        (lambda: motion.page(error=0.0), "error: expected a number above 0"),
        (lambda: motion.page(error=1.0, play=1.0), "expected one of error and play"),
    ):
        with pytest.raises(fp.FoldpathError, match=text):
            call()


def test_rates_by_a_driver_are_those_of_the_motion(motion: fp.Motion) -> None:
    time, step = 0.6 * motion.duration, 1e-5
    (driver,) = motion.drivers(time)
    angles, places = motion.jvp(time, drivers=[1.0])
    after, before = motion.at([time + step, time - step])
    turned = (after - before) / (after - before)[driver]
    hinges = ~np.isnan(turned)
    assert np.abs(angles - turned)[hinges].max() < 1e-6
    assert np.isnan(angles[~hinges]).all()
    assert places.shape == (len(motion.vertices(time)), 3)


def test_products_from_both_sides_are_equal(motion: fp.Motion) -> None:
    time, random = 0.6 * motion.duration, np.random.default_rng(8)
    count = len(motion.vertices(time))
    # To turn and to scale the whole sheet keeps it foldable, and no hinge turns.
    flat = motion.vertices(0.0)[:, :2]
    change = flat * 0.3 + flat[:, ::-1] * [-0.7, 0.7]
    angles, places = motion.jvp(time, vertices=change, drivers=[0.5])
    by_angles, by_places = random.uniform(-1, 1, len(angles)), random.uniform(-1, 1, (count, 3))
    by_vertices, by_drivers = motion.vjp(time, angles=by_angles, vertices=by_places)
    forwards = np.nansum(by_angles * angles) + (by_places * places).sum()
    assert abs((by_vertices * change).sum() + 0.5 * by_drivers[0] - forwards) < 1e-8


def test_many_products_are_those_of_one(motion: fp.Motion) -> None:
    time, random = 0.6 * motion.duration, np.random.default_rng(10)
    flat, edges = motion.pattern.vertices, len(motion.edges)
    # To scale, to turn, to stretch and to shear along the straight creases: the sheet keeps its angles or stays a Miura.
    changes = np.stack([flat, flat[:, ::-1] * [-1, 1], flat * [0, 1], flat * [1, 0]])
    driven = random.uniform(-1, 1, (4, 1))
    rates = motion.jvp(time, changes, driven)
    assert rates[0].shape == (4, edges) and rates[1].shape == (4, *flat.shape[:1], 3)
    by = random.uniform(-1, 1, (3, edges)), random.uniform(-1, 1, (3, len(flat), 3))
    gradients = motion.vjp(time, *by)
    assert gradients[0].shape == (3, *flat.shape) and gradients[1].shape == (3, 1)
    for k in range(3):
        for many, one in ((rates, motion.jvp(time, changes[k], driven[k])), (gradients, motion.vjp(time, by[0][k], by[1][k]))):
            for all_of_them, single in zip(many, one):
                assert np.allclose(all_of_them[k], single, rtol=0, atol=1e-13, equal_nan=True)
    alone = motion.vjp(time, vertices=by[1])[0] + motion.vjp(time, angles=by[0])[0]
    assert np.allclose(alone, gradients[0], rtol=0, atol=1e-12)
    with pytest.raises(fp.FoldpathError, match="drivers: expected the shape"):
        motion.jvp(time, changes, driven[:3])


def test_derivatives_that_do_not_exist_are_refused(motion: fp.Motion) -> None:
    with pytest.raises(fp.FoldpathError, match=r"singular \(smallest singular value \d\.\de-?\d+\)"):
        motion.jvp(0.0)
    with pytest.raises(fp.FoldpathError, match=r"singular \(smallest singular value \d\.\de-?\d+\)"):
        motion.vjp(0.0, angles=np.ones(len(motion.edges)))
    count = len(motion.vertices(0.0))
    broken = np.random.default_rng(9).uniform(-1, 1, (count, 2))
    figures = r"does not fold: of its effect on closure, \d\.\de-?\d+ radians, \d\.\de-?\d+ are left"
    with pytest.raises(fp.FoldpathError, match=figures):
        motion.jvp(0.6 * motion.duration, vertices=broken)
    # A number that is none is refused, but for edges that are no hinge.
    time = 0.6 * motion.duration
    for call, name in (
        (lambda: motion.jvp(time, vertices=np.full((count, 2), np.nan)), "vertices"),
        (lambda: motion.jvp(time, drivers=[np.inf]), "drivers"),
        (lambda: motion.vjp(time, angles=np.full(len(motion.edges), np.nan)), "angles"),
        (lambda: motion.vjp(time, vertices=np.full((count, 3), np.inf)), "vertices"),
    ):
        with pytest.raises(fp.FoldpathError, match=f"{name}: expected finite numbers, found"):
            call()
    assert np.isfinite(motion.vjp(time, angles=motion.at(time))[0]).all()
    # Changes of any size are refused, or have rates in proportion.
    for size in (1e-200, 1e200):
        with pytest.raises(fp.FoldpathError, match="does not fold"):
            motion.jvp(time, vertices=broken * size)
    with pytest.raises(fp.FoldpathError, match="vertices: expected the shape"):
        motion.jvp(0.6 * motion.duration, vertices=[0.0])
    with pytest.raises(fp.FoldpathError, match="finite"):
        motion.drivers(float("nan"))


def test_play_and_torques_are_those_of_the_command(loaded: tuple[fp.Motion, Path], command: Command) -> None:
    motion, path = loaded
    told = command("tolerance", path, "--error", "0.001", "--json")
    assert fp.tolerance(motion, 0.001) == json.loads(told.out)
    play = fp.tolerance(motion, 0.001)["max_play"]
    assert fp.tolerance(motion, play=play)["error"] == pytest.approx(0.001)
    drives = path.parent / "drives.csv"
    drives.write_text("servo,1e-9,60\n")
    told = command(
        "loads", path, "--areal-density=0.8", "--unit=mm", "--gravity=0,-9.81,0", "--drives", drives, "--json"
    )
    for table in (drives, [("servo", 1e-9, 60.0)]):
        loads = fp.loads(motion, 0.8, unit="mm", gravity=(0.0, -9.81, 0.0), drives=table)
        assert loads == json.loads(told.out)
    with pytest.raises(fp.FoldpathError, match="NAME,STALL_TORQUE_NM,SPEED_DEG_PER_S"):
        fp.loads(motion, 0.8, unit="mm", drives=path)
    # Springs of single hinges, whichever way they are named.
    springs = np.full(len(motion.edges), np.nan)
    hinge = int(motion.hinges[0])
    springs[hinge] = 0.02
    told = json.loads(
        command("loads", path, "--areal-density=0.8", "--unit=mm", f"--spring={hinge}=0.02", "--json").out
    )
    everywhere = fp.loads(motion, 0.8, unit="mm", spring=0.02)
    assert everywhere["torques"] != told["torques"]
    for spring in ({hinge: 0.02}, springs):
        assert fp.loads(motion, 0.8, unit="mm", spring=spring, timeout=60) == told
    shared = fp.loads(motion, 0.8, unit="mm", spring=0.02, drivers=2)
    told = json.loads(command("loads", path, "--areal-density=0.8", "--unit=mm", "--spring=0.02", "--drivers=2", "--json").out)
    assert shared == told and abs(shared["peak"]["torque"]) < abs(everywhere["peak"]["torque"])
    with pytest.raises(fp.FoldpathError, match="expected 1 to 31 drivers"):
        fp.loads(motion, 0.8, unit="mm", drivers=0)
    with pytest.raises(fp.FoldpathError, match="is no hinge, and has no spring"):
        fp.loads(motion, 0.8, unit="mm", spring={0: 1.0})
    for call in (lambda: fp.loads(motion, 0.8, unit="mm", timeout=0), lambda: fp.tolerance(motion, 0.001, timeout=0)):
        with pytest.raises(fp.FoldpathError, match="time ran out before"):
            call()
    with pytest.raises(fp.FoldpathError, match="unit of length"):
        fp.loads(motion, 0.8)
    with pytest.raises(fp.FoldpathError, match="expected one of error and play"):
        fp.tolerance(motion)
