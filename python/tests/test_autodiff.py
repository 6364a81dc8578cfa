"""Derivatives for packages that differentiate. Tests that need such a package are skipped where it is not installed."""

from __future__ import annotations

import doctest
import importlib
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import foldpath as fp
import numpy as np
import pytest
from foldpath._folded import Closed, Folded

TIME = 1.5
STEP = 1e-5


def sheet(angle: float) -> fp.Pattern:
    """Return a Miura: sheets of other angles are foldable changes of it."""
    return fp.miura(3, 4, angle=angle)


@pytest.fixture(scope="module")
def motion() -> fp.Motion:
    found = fp.plan(sheet(60.0)).motion
    assert found is not None
    return found


@pytest.fixture(scope="module")
def change() -> np.ndarray:
    """Return the derivative of the vertices by the angle of the sheet, degrees."""
    return (sheet(60 + STEP).vertices - sheet(60 - STEP).vertices) / (2 * STEP)


@pytest.fixture(scope="module")
def turned_sheet() -> fp.Pattern:
    """Return a sheet without a crease along the x axis."""
    pattern = sheet(60)
    return pattern.moved(pattern.vertices @ [[0.8, 0.6], [-0.6, 0.8]])


def differences(function: Callable[..., Any], driven: float) -> tuple[np.ndarray, np.ndarray]:
    """Return central differences of what folds a sheet, by its angle and a driver that turns by ``driven`` a degree."""
    ends = [function(sheet(60 + sign * STEP).vertices, sign * STEP * driven) for sign in (1, -1)]
    angles, places = ((np.asarray(a) - np.asarray(b)) / (2 * STEP) for a, b in zip(*ends))
    return angles, places


def weights(motion: fp.Motion) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(5)
    by_angles = np.where(np.isnan(motion.fold_angles[0]), 0, random.uniform(-1, 1, len(motion.edges)))
    return by_angles, random.uniform(-1, 1, motion.vertices(0.0).shape)


def test_the_folded_sheet_is_that_of_the_motion(motion: fp.Motion) -> None:
    folded = Folded(motion, TIME)
    angles, places = folded.fold(*folded.arguments(None, None))
    assert np.nanmax(np.abs(angles - motion.at(TIME))) < 1e-6
    assert np.abs(places - motion.vertices(TIME)).max() < 1e-6
    # Another driver angle is reached, however far.
    driven = folded.angles[folded.drivers] * 0.4
    angles, _ = folded.fold(folded.flat, driven)
    assert np.abs(angles[folded.drivers] - driven).max() < 1e-11
    assert np.abs(fp.closure(motion.pattern, angles)[0]).max() < 1e-12


def test_derivatives_are_those_of_sheets_closed_anew(motion: fp.Motion, change: np.ndarray) -> None:
    folded, driven = Folded(motion, TIME), 0.3
    start = folded.angles[folded.drivers]
    turned, moved = differences(lambda flat, by: folded.fold(flat, start + by), driven)
    angles, _ = folded.fold(folded.flat, start)
    rates = folded.jvp(folded.flat, angles, change, np.array([driven]))
    assert np.nanmax(np.abs(rates[0] - turned)) < 1e-6
    assert np.abs(rates[1] - moved).max() < 1e-6
    by_angles, by_places = weights(motion)
    by_vertices, by_drivers = folded.vjp(folded.flat, angles, by_angles, by_places)
    forwards = np.nansum(by_angles * turned) + (by_places * moved).sum()
    assert abs((by_vertices * change).sum() + by_drivers[0] * driven - forwards) < 1e-6


def test_derivatives_of_residuals_are_those_of_moved_sheets(motion: fp.Motion, turned_sheet: fp.Pattern) -> None:
    random = np.random.default_rng(6)
    closed, flat = Closed(turned_sheet), turned_sheet.vertices
    angles = np.nan_to_num(motion.at(TIME)) + random.uniform(-0.1, 0.1, len(motion.edges))
    turned, moved = random.uniform(-1, 1, angles.shape), random.uniform(-1, 1, flat.shape)
    ends = [closed.residuals(angles + sign * STEP * turned, flat + sign * STEP * moved) for sign in (1, -1)]
    rates = closed.jvp(angles, flat, turned, moved)
    assert np.abs(rates - (ends[0] - ends[1]) / (2 * STEP)).max() < 1e-8
    by = random.uniform(-1, 1, rates.shape)
    by_angles, by_vertices = closed.vjp(angles, flat, by)
    assert abs((by_angles * turned).sum() + (by_vertices * moved).sum() - (by * rates).sum()) < 1e-10


def test_sheets_that_do_not_fold_are_refused(motion: fp.Motion) -> None:
    flat = Folded(motion, 0.5)
    with pytest.raises(fp.FoldpathError, match="smallest singular value"):
        flat.fold(flat.flat, np.zeros(1))
    with pytest.raises(fp.FoldpathError, match="vertices: expected the shape"):
        flat.arguments(np.zeros((2, 2)), None)
    with pytest.raises(fp.FoldpathError, match="drivers: expected the shape"):
        flat.arguments(None, np.zeros(2))
    broken = flat.flat + np.random.default_rng(7).uniform(-0.2, 0.2, flat.flat.shape)
    with pytest.raises(fp.FoldpathError, match="does not close"):
        flat.fold(broken, flat.angles[flat.drivers])
    with pytest.raises(fp.FoldpathError, match="drivers that are given"):
        flat.drivers = flat.drivers * 2
        flat.fold(flat.flat, np.zeros(2))


@pytest.mark.parametrize("name", ["jax", "torch"])
def test_what_is_missing_is_named(name: str) -> None:
    code = f"import sys; sys.modules['{name}'] = None; import foldpath as fp; fp.{name}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    text = f"ImportError: foldpath.{name} needs {name}, which foldpath does not install: pip install {name}"
    assert text in done.stderr and done.returncode == 1
    with pytest.raises(AttributeError, match="no attribute 'numpy'"):
        fp.numpy  # noqa: B018


@pytest.mark.parametrize("name", ["jax", "torch"])
def test_the_examples_run(name: str) -> None:
    package = pytest.importorskip(name)
    module = importlib.import_module(f"foldpath.{name}")
    failed, tried = doctest.testmod(module, extraglobs={name: package})
    assert tried > 0 and failed == 0


def test_torch_has_the_derivatives(motion: fp.Motion, change: np.ndarray, turned_sheet: fp.Pattern) -> None:
    torch = pytest.importorskip("torch")
    folded = Folded(motion, TIME)
    by_angles, by_places = (torch.tensor(by) for by in weights(motion))
    flat = torch.tensor(folded.flat, requires_grad=True)
    start = torch.tensor(folded.angles[folded.drivers], requires_grad=True)

    def number(flat: Any, driven: Any) -> Any:
        angles, places = fp.torch.fold(motion, TIME, flat, driven)
        return torch.nansum(by_angles * angles) + (by_places * places).sum()

    number(flat, start).backward()
    ends = [
        number(torch.tensor(sheet(60 + sign * STEP).vertices), start.detach() + 0.3 * sign * STEP) for sign in (1, -1)
    ]
    found = (flat.grad * torch.tensor(change)).sum() + 0.3 * start.grad[0]
    assert abs(float(found) - float(ends[0] - ends[1]) / (2 * STEP)) < 1e-6
    # Forward mode tells the same.
    with (forward := torch.autograd.forward_ad).dual_level():
        moved = forward.make_dual(flat.detach(), torch.tensor(change))
        turned = forward.make_dual(start.detach(), torch.tensor([0.3], dtype=torch.float64))
        rate = forward.unpack_dual(number(moved, turned)).tangent
        assert abs(float(rate) - float(found)) < 1e-8
    angles = torch.tensor(np.nan_to_num(motion.at(TIME)) + 0.01, requires_grad=True)
    flat = torch.tensor(turned_sheet.vertices, requires_grad=True)
    assert torch.autograd.gradcheck(lambda *given: fp.torch.closure(turned_sheet, *given), (angles, flat), atol=1e-6)
    # Gradients have the type of what they are by.
    single = torch.tensor([1.0, 1.0], dtype=torch.float32, requires_grad=True)
    fp.torch.fold(motion, TIME, torch.tensor(folded.flat) * single)[1].sum().backward()
    assert single.grad.dtype == torch.float32


def test_torch_func_has_the_same_derivatives(motion: fp.Motion, change: np.ndarray, turned_sheet: fp.Pattern) -> None:
    torch = pytest.importorskip("torch")
    folded, func = Folded(motion, TIME), torch.func
    by_angles, by_places = (torch.tensor(by) for by in weights(motion))
    flat, start = torch.tensor(folded.flat), torch.tensor(folded.angles[folded.drivers])

    def fold(flat: Any, driven: Any) -> Any:
        return fp.torch.fold(motion, TIME, flat, driven)

    def number(flat: Any, driven: Any) -> Any:
        angles, places = fold(flat, driven)
        return torch.nansum(by_angles * angles) + (by_places * places).sum()

    given = [at.clone().requires_grad_() for at in (flat, start)]
    number(*given).backward()
    for found in (func.grad(number, argnums=(0, 1))(flat, start), func.vjp(number, flat, start)[1](torch.tensor(1.0))):
        assert all(torch.allclose(by, at.grad, atol=1e-12) for by, at in zip(found, given))
    _, rate = func.jvp(number, (flat, start), (torch.tensor(change), torch.full_like(start, 0.3)))
    assert abs(float(rate - (given[0].grad * torch.tensor(change)).sum() - 0.3 * given[1].grad[0])) < 1e-8
    # A batch has the sheets, and the gradients, of its parts.
    sheets = torch.stack([torch.tensor(sheet(angle).vertices) for angle in (60, 60.1)])
    places = func.vmap(fold, (0, None))(sheets, start)[1]
    assert torch.equal(places, torch.stack([fold(part, start)[1] for part in sheets]))
    gradients = func.vmap(func.grad(number), (0, None))(sheets, start)
    assert torch.equal(gradients, torch.stack([func.grad(number)(part, start) for part in sheets]))

    def closed(angles: Any, flat: Any) -> Any:
        return fp.torch.closure(turned_sheet, angles, flat)

    angles = torch.tensor(np.nan_to_num(motion.at(TIME)) + 0.01)
    for jacobian in (func.jacrev(closed), func.jacfwd(closed)):
        rows = jacobian(angles, torch.tensor(turned_sheet.vertices)).reshape(-1, len(angles))
        assert np.abs(rows.numpy() - fp.closure(turned_sheet, angles.numpy())[1].toarray()).max() < 1e-12
    with pytest.raises(fp.FoldpathError, match="second derivatives are not known"):
        func.hessian(lambda driven: number(flat, driven))(start)


def test_jax_has_the_derivatives(motion: fp.Motion, change: np.ndarray) -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    folded = Folded(motion, TIME)
    by_angles, by_places = weights(motion)
    start = folded.angles[folded.drivers]

    def number(flat: Any, driven: Any) -> Any:
        angles, places = fp.jax.fold(motion, TIME, flat, driven)
        return jax.numpy.nansum(by_angles * angles) + (by_places * places).sum()

    gradient = jax.jit(jax.grad(number, argnums=(0, 1)))
    by_vertices, by_drivers = gradient(folded.flat, start)
    ends = [number(sheet(60 + sign * STEP).vertices, start + 0.3 * sign * STEP) for sign in (1, -1)]
    found = (by_vertices * change).sum() + 0.3 * by_drivers[0]
    assert abs(float(found) - float(ends[0] - ends[1]) / (2 * STEP)) < 1e-6
    angles, random = np.nan_to_num(motion.at(TIME)) + 0.01, np.random.default_rng(8)
    rows = fp.closure(motion.pattern, angles)[0].shape
    by, turned, moved = (random.uniform(-1, 1, shape) for shape in (rows, angles.shape, folded.flat.shape))
    _, back = jax.vjp(lambda *given: fp.jax.closure(motion.pattern, *given), angles, folded.flat)
    by_angles, by_flat = back(by)
    rates = Closed(motion.pattern).jvp(angles, folded.flat, turned, moved)
    assert abs(float((by_angles * turned).sum() + (by_flat * moved).sum()) - (by * rates).sum()) < 1e-9
