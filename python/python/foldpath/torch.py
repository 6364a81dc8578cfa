"""Derivatives for PyTorch: the folded sheet and closure residuals as functions with derivatives of their own.

>>> import foldpath as fp
>>> motion = fp.plan(fp.miura(3, 3)).motion
>>> vertices = torch.tensor(motion.pattern.vertices, requires_grad=True)
>>> angles, places = fp.torch.fold(motion, 1.0, vertices)
>>> (places[-1] - places[0]).norm().backward()
>>> vertices.grad.shape == vertices.shape
True

Tensors are 64-bit floats on the CPU; others are converted, and so are their gradients. Derivatives are those of
``torch.autograd``, backwards and with the dual numbers of ``torch.autograd.forward_ad``, and those of ``torch.func``: ``grad``,
``vjp``, ``jvp``, ``jacrev``, ``jacfwd`` and ``vmap``, which folds the sheets of a batch one after the other. Second derivatives
raise :class:`foldpath.FoldpathError`.
"""

# Types are checked where PyTorch is installed and where it is not.
# mypy: disable-error-code="import-not-found, misc, no-any-return, no-untyped-call, override, unused-ignore"

from __future__ import annotations

from typing import Any

import numpy as np

from ._error import FoldpathError
from ._folded import Closed, Folded, missing
from ._motion import Motion
from ._pattern import Pattern

try:
    import torch
except ImportError:
    raise missing("torch", ["torch"]) from None

__all__ = ["closure", "fold"]


def fold(
    motion: Motion, t: float, vertices: torch.Tensor | None = None, drivers: torch.Tensor | None = None
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return fold angles, (E,), and folded vertices, (V, 3), of the sheet at a time of a motion.

    ``vertices`` has the vertices of the flat pattern, (V, 2), and ``drivers`` the angles of ``motion.drivers(t)``, radians;
    those left out are those of the motion. The sheet is the closed one that is nearest to the motion with these drivers. The
    panel in the middle stays where it is drawn. Angles are nan for edges that are no hinge.

    Both results have derivatives by ``vertices``, for changes with which the pattern still folds, and by ``drivers``, backwards
    and with dual numbers. Raises :class:`foldpath.FoldpathError` at singular configurations, as flat, if the sheet does not
    close, and with dual numbers for a change with which the pattern does not fold.
    """
    folded = Folded(motion, t)
    flat, driven = folded.arguments(None, None)
    given = torch.as_tensor(flat) if vertices is None else vertices
    return _Fold.apply(folded, given, torch.as_tensor(driven) if drivers is None else drivers)


def closure(pattern: Pattern, angles: torch.Tensor, vertices: torch.Tensor | None = None) -> torch.Tensor:
    """Return the closure residuals of :func:`foldpath.closure`, (R, 3), at fold angles, (E,), in radians.

    ``vertices`` has the vertices of the flat pattern, (V, 2); without them they are those of the pattern. The residuals have
    derivatives by both, backwards and with dual numbers. Needs scipy.

    The frame of a vertex' residual begins at its first crease counter-clockwise from +x: where a crease passes +x, the
    components change by a jump and the length does not. A sheet that is turned a little has no such crease.
    """
    flat = torch.as_tensor(pattern.vertices) if vertices is None else vertices
    return _Closure.apply(Closed(pattern), angles, flat)


def _array(tensor: torch.Tensor) -> Any:
    return tensor.detach().to("cpu", torch.float64).contiguous().numpy()


def _each(function: Any, info: Any, in_dims: Any, what: Any, *tensors: torch.Tensor) -> tuple[Any, Any]:
    """Apply a function to each part of a batch: the rule of its ``vmap``."""

    def part(i: int) -> Any:
        return (at if dim is None else at.select(dim, i) for at, dim in zip(tensors, in_dims[1:]))

    results = [function.apply(what, *part(i)) for i in range(info.batch_size)]
    if isinstance(results[0], torch.Tensor):
        return torch.stack(results), 0
    return tuple(torch.stack(each) for each in zip(*results)), (0,) * len(results[0])


class _Numpy(torch.autograd.Function):
    """A function of numpy's arrays: derivatives are such functions, so that they may be mapped, and have none themselves."""

    @staticmethod
    def forward(work: Any, *tensors: torch.Tensor) -> tuple[torch.Tensor, ...]:
        return tuple(torch.as_tensor(np.asarray(array)) for array in work(*map(_array, tensors)))

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        pass

    @staticmethod
    def backward(ctx: Any, *by: torch.Tensor) -> Any:
        raise FoldpathError("second derivatives are not known")

    jvp = backward

    @staticmethod
    def vmap(info: Any, in_dims: Any, work: Any, *tensors: torch.Tensor) -> Any:
        return _each(_Numpy, info, in_dims, work, *tensors)


class _Fold(torch.autograd.Function):
    @staticmethod
    def forward(folded: Folded, vertices: torch.Tensor, drivers: torch.Tensor) -> Any:
        return _Numpy.forward(lambda *given: folded.fold(*folded.arguments(*given)), vertices, drivers)

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.folded, vertices, drivers = inputs
        ctx.save_for_backward(vertices, drivers, output[0])
        ctx.save_for_forward(vertices, drivers, output[0])

    @staticmethod
    def backward(ctx: Any, by_angles: torch.Tensor, by_places: torch.Tensor) -> Any:
        vertices, drivers, angles = ctx.saved_tensors
        gradients = _Numpy.apply(ctx.folded.vjp, vertices, angles, by_angles, by_places)
        return None, gradients[0].to(vertices), gradients[1].to(drivers)

    @staticmethod
    def jvp(ctx: Any, _folded: Any, change: Any, driven: Any) -> Any:
        vertices, drivers, angles = ctx.saved_tensors
        return _Numpy.apply(ctx.folded.jvp, vertices, angles, _rate(change, vertices), _rate(driven, drivers))

    @staticmethod
    def vmap(info: Any, in_dims: Any, *given: Any) -> Any:
        return _each(_Fold, info, in_dims, *given)


class _Closure(torch.autograd.Function):
    @staticmethod
    def forward(closed: Closed, angles: torch.Tensor, vertices: torch.Tensor) -> torch.Tensor:
        return torch.as_tensor(closed.residuals(_array(angles), _array(vertices)))

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.closed, angles, vertices = inputs
        ctx.save_for_backward(angles, vertices)
        ctx.save_for_forward(angles, vertices)

    @staticmethod
    def backward(ctx: Any, by: torch.Tensor) -> Any:
        angles, vertices = ctx.saved_tensors
        gradients = _Numpy.apply(ctx.closed.vjp, angles, vertices, by)
        return None, gradients[0].to(angles), gradients[1].to(vertices)

    @staticmethod
    def jvp(ctx: Any, _closed: Any, turned: Any, moved: Any) -> torch.Tensor:
        angles, vertices = ctx.saved_tensors
        changes = _rate(turned, angles), _rate(moved, vertices)
        return _Numpy.apply(lambda *given: (ctx.closed.jvp(*given),), angles, vertices, *changes)[0]

    @staticmethod
    def vmap(info: Any, in_dims: Any, *given: Any) -> Any:
        return _each(_Closure, info, in_dims, *given)


def _rate(change: torch.Tensor | None, of: torch.Tensor) -> torch.Tensor:
    return torch.zeros_like(of) if change is None else change
