"""The notebook that fits a sheet to a surface, and the generator of its sheets."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import foldpath as fp
import numpy as np

HERE = Path(__file__).parents[1]
sys.path.append(str(HERE.parent / "tests" / "fit"))

from generalised_miura import GeneralisedMiura  # noqa: E402


def test_the_generator_makes_sheets_that_fold() -> None:
    random = np.random.default_rng(60)
    for rows, columns, spread in ((10, 10, 0.05), (3, 7, 0.15), (6, 4, 0.1)):
        sheet = GeneralisedMiura(rows, columns)
        parameters = sheet.random(random, spread)
        vertices = sheet.vertices(parameters)
        driver = columns + 1
        angles = sheet.angles(parameters, driver, 2.0)
        pattern = fp.Pattern(vertices=vertices, edges=sheet.edges(), faces=sheet.faces(), angles=angles)
        assert abs(angles[driver] - 2.0) < 1e-14
        assert np.abs(fp.closure(pattern, angles)[0]).max() < 1e-12
        plan = fp.plan(pattern)
        assert plan.outcome == "planned" and plan.motion is not None
        # No two of its inner vertices are equal, so that no crease group has more than one crease.
        assert plan.to_dict()["groups"] == len(pattern.hinges)
        # The sheet closes at every angle of its driver.
        time = 0.5 * plan.motion.duration
        closed = sheet.angles(parameters, driver, plan.motion.at(time)[driver])
        assert np.nanmax(np.abs(closed - plan.motion.at(time))) < 1e-5
        # Its derivatives are those of other sheets that fold.
        derivatives = sheet.derivatives(parameters)
        change = random.uniform(-1, 1, sheet.count)
        ends = [sheet.vertices(parameters + sign * 1e-6 * change) for sign in (1, -1)]
        along = np.tensordot(change, derivatives, axes=1)
        assert np.abs((ends[0] - ends[1]) / 2e-6 - along).max() < 1e-6
        plan.motion.jvp(plan.motion.duration, vertices=along)


def test_the_fit_ends_near_the_surface_planned_and_proved() -> None:
    cells = json.loads((HERE / "fit.ipynb").read_text(encoding="utf-8"))["cells"]
    code = [cell["source"] for cell in cells if cell["cell_type"] == "code" and "matplotlib" not in cell["source"]]
    told: dict[str, object] = {}
    for cell in code:
        exec(compile(cell, "fit.ipynb", "exec"), told)
    # As docs say: a twentieth of the start's distance, and 0.2 % of the diagonal.
    assert told["after"] < 0.06 * told["before"] and told["after"] < 0.002 * told["diagonal"]
