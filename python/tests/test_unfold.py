"""Crease patterns of folded shapes."""

from __future__ import annotations

import json
from pathlib import Path

import foldpath as fp
import numpy as np
import pytest
from conftest import Command

TENT = "v 0 0 0\nv 2 0 0\nv 2 1 1\nv 0 1 1\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\nf 4 3 5 6\n"
CUBE_CORNER = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\n"


def test_a_pattern_is_that_of_the_command(command: Command, tmp_path: Path) -> None:
    shape, net = tmp_path / "tent.obj", tmp_path / "net.fold"
    shape.write_text(TENT)
    told = command("unfold", shape, "-o", net, "--unit", "mm", "--json")
    for source in (shape, TENT.encode()):
        unfolding = fp.unfold(source, unit="mm")
        assert unfolding.outcome == "unfolded" and unfolding.reason is None
        assert unfolding.to_dict() == json.loads(told.out)
        pattern, theirs = unfolding.pattern, fp.read(net)
        assert pattern is not None and pattern.unit == theirs.unit == "mm"
        assert np.array_equal(pattern.vertices, theirs.vertices)
        assert np.array_equal(pattern.goal, theirs.goal, equal_nan=True)
    assert np.nanmax(np.abs(pattern.goal)) == pytest.approx(np.pi / 2)
    assert fp.plan(pattern).outcome == "planned"


def test_a_folded_motion_unfolds_to_its_pattern(tmp_path: Path) -> None:
    motion = fp.plan(fp.miura(3, 3)).motion
    assert motion is not None
    motion.save(tmp_path / "path.fold")
    pattern = fp.unfold(tmp_path / "path.fold").pattern
    assert pattern is not None and len(pattern.hinges) == len(motion.hinges)
    told = json.loads((tmp_path / "path.fold").read_text())
    assert fp.unfold(told, frame=1).to_dict()["faces"] == 9


def test_a_shape_that_does_not_unfold_is_an_outcome() -> None:
    corner = fp.unfold(CUBE_CORNER.encode(), cut="none")
    assert corner.outcome == "not_developable" and corner.pattern is None
    assert corner.reason is not None and "--cut auto" in corner.reason
    assert fp.unfold(CUBE_CORNER.encode()).outcome == "unfolded"
    with pytest.raises(fp.FoldpathError, match="--max-defect: expected degrees above 0 and at most 10, found 11"):
        fp.unfold(TENT.encode(), max_defect=11)
    with pytest.raises(fp.FoldpathError, match="frame"):
        fp.unfold(TENT.encode(), frame=1)
    told = fp.miura(2, 2).to_dict() | {"frame_unit": "m", "frame_classes": ["foldedForm"]}
    told["vertices_coords"] = [[x, y, 0] for x, y in told["vertices_coords"]]
    with pytest.raises(fp.FoldpathError, match="expected no unit, or mm, found m"):
        fp.unfold(told, unit="mm")
