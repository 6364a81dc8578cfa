"""Reading and making patterns; closure residuals and their Jacobian."""

from __future__ import annotations

import io
import json
import pickle
from pathlib import Path

import foldpath as fp
import numpy as np
import pytest

PATTERNS = Path(__file__).parents[2] / "patterns"


def test_a_pattern_is_read_from_a_file_bytes_a_stream_and_a_dictionary() -> None:
    path = PATTERNS / "miura-3x3.fold"
    data = path.read_bytes()
    sources = [path, str(path), data, bytearray(data), io.BytesIO(data), json.loads(data)]
    for pattern in map(fp.read, sources):
        assert pattern.vertices.shape == (16, 2)
        assert pattern.edges.shape == (24, 2)
        assert len(pattern.faces) == 9
        assert len(pattern.hinges) == 12
        assert np.isnan(pattern.goal).sum() == 12
        assert pattern.letters.count("B") == 12
        assert fp.plan(pattern).outcome == "planned"
    assert fp.read(path).file == str(path)


def test_families_are_those_of_the_command() -> None:
    for name, pattern in {
        "miura-3x3": fp.miura(rows=3, columns=3),
        "waterbomb-4x6": fp.waterbomb(4, 6, fold=0.3),
        "resch-3x3": fp.resch(),
        "quad-24x24": fp.quad(),
        "kresling-2x6": fp.kresling(),
        "square-twist-1x1": fp.square_twist(),
        "yoshimura-12x12": fp.yoshimura(12, 12),
    }.items():
        same = fp.read(PATTERNS / f"{name}.fold")
        assert np.array_equal(pattern.vertices, same.vertices)
        assert np.array_equal(pattern.edges, same.edges)
    with pytest.raises(fp.FoldpathError, match="--angle: expected 1 to 89 degrees, found 90"):
        fp.miura(2, 2, angle=90)


def test_a_pattern_survives_pickling() -> None:
    pattern = fp.read(PATTERNS / "square-twist-1x1.fold")
    again = pickle.loads(pickle.dumps(pattern))
    assert np.array_equal(again.vertices, pattern.vertices)
    assert again.file == pattern.file and again.title == pattern.title


def test_info_is_the_object_of_the_command() -> None:
    info = fp.miura(3, 3).info()
    assert info["groups"] == 2 and info["essential_vertices"] == 1
    assert info["verdict"] == "likely"


def test_drawings_are_read_with_their_options() -> None:
    drawing = (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 2">'
        '<path d="M0 0 H2 V2 H0 Z" stroke="black" fill="none"/>'
        '<path d="M0 1 H2" stroke="teal" fill="none"/></svg>'
    ).encode()
    pattern = fp.read(drawing, colors="teal=V,black=B", tolerance=0.01)
    assert pattern.letters.count("V") == 1
    with pytest.raises(fp.FoldpathError, match="--tolerance: expected a finite length above 0"):
        fp.read(drawing, tolerance=-1)
    with pytest.raises(fp.FoldpathError, match="--straighten: expected auto, on, off, found maybe"):
        fp.read(drawing, straighten="maybe")  # type: ignore[arg-type]


def test_errors_have_the_text_and_the_place_of_the_command_line(tmp_path: Path) -> None:
    path = tmp_path / "broken.fold"
    path.write_text('{\n"vertices_coords": [[0, 0], [1, "x"]]}')
    with pytest.raises(fp.FoldpathError) as caught:
        fp.read(path)
    error = caught.value
    assert isinstance(error, ValueError)
    assert str(error).startswith(f"{path}:2:")
    assert error.file == str(path) and error.line == 2
    assert pickle.loads(pickle.dumps(error)).line == 2
    with pytest.raises(fp.FoldpathError, match="No such file"):
        fp.read(tmp_path / "missing.fold")
    with pytest.raises(fp.FoldpathError, match="expected a file, bytes or a dictionary"):
        fp.read(5)  # type: ignore[arg-type]


def differences(pattern: fp.Pattern, angles: np.ndarray, step: float) -> np.ndarray:
    """Return the Jacobian by central differences."""
    columns = np.zeros((3 * len(fp.closure(pattern, angles)[0]), len(angles)))
    for hinge in pattern.hinges:
        ends = []
        for sign in (1, -1):
            moved = angles.copy()
            moved[hinge] += sign * step
            ends.append(fp.closure(pattern, moved)[0].ravel())
        columns[:, hinge] = (ends[0] - ends[1]) / (2 * step)
    return columns


@pytest.mark.parametrize("name", ["miura-3x3", "waterbomb-4x6"])
def test_the_jacobian_is_that_of_central_differences(name: str) -> None:
    pytest.importorskip("scipy")
    pattern = fp.read(PATTERNS / f"{name}.fold")
    angles = np.full(len(pattern.edges), np.nan)
    angles[pattern.hinges] = np.random.default_rng(5).uniform(-1, 1, len(pattern.hinges))
    residuals, jacobian = fp.closure(pattern, angles)
    assert residuals.shape == (len(pattern.closure_vertices), 3)
    assert jacobian.shape == (residuals.size, len(pattern.edges))
    # Central differences with a step of 1e-5 are exact to about 1e-10.
    assert np.abs(jacobian.toarray() - differences(pattern, angles, 1e-5)).max() < 1e-9


def test_a_hole_has_two_residuals() -> None:
    pytest.importorskip("scipy")
    # A ring of four trapezoids round a square hole.
    outer, inner = [[0, 0], [3, 0], [3, 3], [0, 3]], [[1, 1], [2, 1], [2, 2], [1, 2]]
    ring = {
        "vertices_coords": outer + inner,
        "edges_vertices": [[i, (i + 1) % 4] for i in range(4)]
        + [[4 + i, 4 + (i + 1) % 4] for i in range(4)]
        + [[i, 4 + i] for i in range(4)],
        "edges_assignment": ["B"] * 8 + ["U"] * 4,
        "faces_vertices": [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)],
    }
    pattern = fp.read(ring)
    angles = np.zeros(12)
    angles[8:] = [0.1, -0.2, 0.3, 0.4]
    residuals, jacobian = fp.closure(pattern, angles)
    assert len(pattern.closure_vertices) == 0 and residuals.shape == (2, 3)
    assert np.abs(jacobian.toarray() - differences(pattern, angles, 1e-5)).max() < 1e-9


def test_closure_of_a_planned_motion_is_within_its_certificate() -> None:
    pytest.importorskip("scipy")
    pattern = fp.miura(4, 5)
    plan = fp.plan(pattern)
    assert plan.motion is not None
    for angles in plan.motion.fold_angles:
        residuals, _ = fp.closure(pattern, angles)
        assert np.linalg.norm(residuals, axis=1).max() <= plan.to_dict()["max_closure"] + 1e-14
    wrong = plan.motion.fold_angles[-1] * 0.7
    assert np.abs(fp.closure(pattern, wrong)[0]).max() > 1e-2


def test_closure_takes_arrays_of_other_types_and_refuses_others() -> None:
    pytest.importorskip("scipy")
    pattern = fp.miura(2, 2)
    angles = np.nan_to_num(pattern.goal)
    expected = fp.closure(pattern, angles)[0]
    strided = np.zeros((len(angles), 3))
    strided[:, 1] = angles
    for same in (list(angles), tuple(angles), strided[:, 1], np.asfortranarray(angles)):
        assert np.array_equal(fp.closure(pattern, same)[0], expected)
    single = fp.closure(pattern, angles.astype(np.float32))[0]
    assert np.allclose(single, expected, atol=1e-6)
    for wrong, text in [
        (angles[:-1], "expected one for each of 12 edges, found 11"),
        (angles * np.nan, "expected a number for hinge"),
        (angles + np.inf, "expected a number for hinge"),
        (angles[None], "expected one dimension, found 2"),
        (["x"], "angles: expected numbers"),
    ]:
        with pytest.raises(fp.FoldpathError, match=text):
            fp.closure(pattern, wrong)


@pytest.mark.parametrize("name", ["miura-3x3", "waterbomb-4x6"])
def test_the_jacobian_by_vertices_is_that_of_central_differences(name: str) -> None:
    pytest.importorskip("scipy")
    file = json.loads((PATTERNS / f"{name}.fold").read_text())
    # The condition of a vertex begins with its first crease counter-clockwise from -x. A crease along -x would be the first or
    # the last one after a small move, so the sheet is turned.
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    file["vertices_coords"] = (np.array(file["vertices_coords"]) @ turn.T).tolist()
    pattern = fp.read(file)
    angles = np.full(len(pattern.edges), np.nan)
    angles[pattern.hinges] = np.random.default_rng(6).uniform(-1, 1, len(pattern.hinges))
    residuals, jacobian = fp.closure(pattern, angles, wrt="vertices")
    assert jacobian.shape == (residuals.size, 2 * len(pattern.vertices))
    assert np.array_equal(residuals, fp.closure(pattern, angles)[0])
    step = 1e-5
    for coordinate in range(0, jacobian.shape[1], 5):
        ends = []
        for sign in (1, -1):
            moved = json.loads(json.dumps(file))
            moved["vertices_coords"][coordinate // 2][coordinate % 2] += sign * step
            ends.append(fp.closure(fp.read(moved), angles)[0].ravel())
        column = (ends[0] - ends[1]) / (2 * step)
        assert np.abs(jacobian[:, [coordinate]].toarray().ravel() - column).max() < 1e-9


def test_a_jacobian_by_something_else_is_refused() -> None:
    pattern = fp.miura(2, 2)
    with pytest.raises(fp.FoldpathError, match="expected angles or vertices, found edges"):
        fp.closure(pattern, np.zeros(len(pattern.edges)), wrt="edges")  # type: ignore[arg-type]


def test_a_pattern_is_made_of_arrays_and_saved(tmp_path: Path) -> None:
    known = fp.read(PATTERNS / "miura-3x3.fold", unit="mm")
    made = fp.Pattern(
        vertices=known.vertices,
        edges=known.edges,
        letters=known.letters,
        faces=known.faces,
        angles=known.goal,
        unit=known.unit,
        title="made",
    )
    made.save(tmp_path / "made.fold")
    again = [made, fp.read(tmp_path / "made.fold"), fp.read(made.to_dict()), pickle.loads(pickle.dumps(made))]
    for pattern in again:
        assert pattern.title == "made" and pattern.unit == "mm"
        assert np.array_equal(pattern.vertices, known.vertices)
        assert np.array_equal(pattern.edges, known.edges)
        assert pattern.letters == known.letters and pattern.faces == known.faces
        assert np.allclose(pattern.goal, known.goal, rtol=0, atol=1e-15, equal_nan=True)
    assert fp.plan(made).outcome == "planned"
    # Without faces, letters and angles, the reader finds what it can.
    assert len(fp.Pattern(vertices=known.vertices, edges=known.edges).faces) == 9
    for arrays, message in [
        ({"vertices": [1.0, 2.0]}, "vertices: expected two numbers for each"),
        ({"edges": [[0, 1.5]]}, "edges: expected whole numbers"),
        ({"angles": [0.0]}, "angles: expected the shape"),
        ({"edges": [[0, 99]]}, "99"),
        ({"letters": "M"}, "edges_assignment"),
    ]:
        with pytest.raises(fp.FoldpathError, match=message):
            fp.Pattern(**{"vertices": known.vertices, "edges": known.edges, **arrays})  # type: ignore[arg-type]
    with pytest.raises(fp.FoldpathError, match="expected a name that ends in .fold"):
        made.save(tmp_path / "made.json")
