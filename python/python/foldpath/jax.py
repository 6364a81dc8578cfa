"""Derivatives for JAX: the folded sheet and closure residuals as functions with derivatives of their own.

>>> import foldpath as fp
>>> motion = fp.plan(fp.miura(3, 3)).motion
>>> def length(vertices):
...     angles, places = fp.jax.fold(motion, 1.0, vertices)
...     return jax.numpy.linalg.norm(places[-1] - places[0])
>>> jax.grad(length)(motion.pattern.vertices).shape == motion.pattern.vertices.shape
True

The functions may be compiled by ``jax.jit``: they are calls of the host. Numbers have 64 bits if JAX is told to use them,
by ``jax.config.update("jax_enable_x64", True)``. Otherwise results are rounded to 32 bits, and so are the vertices given.
"""

# Types are checked where JAX is installed and where it is not.
# mypy: disable-error-code="import-not-found, misc, no-any-return, no-untyped-call, override, unused-ignore"

from __future__ import annotations

from typing import Any

import numpy as np

from ._folded import Closed, Folded, missing
from ._motion import Motion
from ._pattern import Pattern

try:
    import jax
    import jax.numpy as jnp
except ImportError:
    raise missing("jax", ["jax"]) from None

__all__ = ["closure", "fold"]


def fold(motion: Motion, t: float, vertices: Any = None, drivers: Any = None) -> tuple[jax.Array, jax.Array]:
    """Return fold angles, (E,), and folded vertices, (V, 3), of the sheet at a time of a motion.

    ``vertices`` has the vertices of the flat pattern, (V, 2), and ``drivers`` the angles of ``motion.drivers(t)``, radians;
    those left out are those of the motion. The sheet is the closed one that is nearest to the motion with these drivers. The
    panel in the middle stays where it is drawn. Angles are nan for edges that are no hinge.

    Both results have derivatives by ``vertices``, for changes with which the pattern still folds, and by ``drivers``, in
    reverse mode (``jax.grad``, ``jax.vjp``). Raises an error at singular configurations, as flat, and if the sheet does not
    close.
    """
    folded = Folded(motion, t)
    flat, driven = folded.arguments(None, None)
    count = len(folded.pattern.edges)

    def value(flat: Any, driven: Any) -> Any:
        shapes = (_shape((count,)), _shape((len(folded.flat), 3)))
        return _call(lambda *given: folded.fold(*folded.arguments(*given)), shapes, flat, driven)

    def forwards(flat: Any, driven: Any) -> Any:
        angles, places = value(flat, driven)
        return (angles, places), (flat, driven, angles)

    def backwards(kept: Any, by: Any) -> Any:
        flat, driven, angles = kept
        shapes = (_shape(flat.shape), _shape(driven.shape))
        return _call(folded.vjp, shapes, flat, angles, *by)

    function = jax.custom_vjp(value)
    function.defvjp(forwards, backwards)
    return function(_numbers(flat, vertices), _numbers(driven, drivers))


def closure(pattern: Pattern, angles: Any, vertices: Any = None) -> jax.Array:
    """Return the closure residuals of :func:`foldpath.closure`, (R, 3), at fold angles, (E,), in radians.

    ``vertices`` has the vertices of the flat pattern, (V, 2); without them they are those of the pattern. The residuals have
    derivatives by both, in reverse mode. Needs scipy.

    The frame of a vertex' residual begins at its first crease counter-clockwise from +x: where a crease passes +x, the
    components change by a jump and the length does not. A sheet that is turned a little has no such crease.
    """
    closed = Closed(pattern)
    rows = len(closed.residuals(np.zeros(len(pattern.edges)), pattern.vertices))

    def value(angles: Any, flat: Any) -> Any:
        return _call(closed.residuals, _shape((rows, 3)), angles, flat)

    def forwards(angles: Any, flat: Any) -> Any:
        return value(angles, flat), (angles, flat)

    def backwards(kept: Any, by: Any) -> Any:
        return _call(closed.vjp, tuple(_shape(given.shape) for given in kept), *kept, by)

    function = jax.custom_vjp(value)
    function.defvjp(forwards, backwards)
    return function(_numbers(angles), _numbers(pattern.vertices, vertices))


def _numbers(usual: Any, given: Any = None) -> jax.Array:
    return jnp.asarray(usual if given is None else given, dtype=float)


def _shape(shape: tuple[int, ...]) -> Any:
    return jax.ShapeDtypeStruct(shape, jnp.zeros(0, dtype=float).dtype)


def _call(work: Any, shapes: Any, *arguments: Any) -> Any:
    """Call a function of numpy's arrays, also from what JAX compiles."""

    def on_host(*given: Any) -> Any:
        result = work(*(np.asarray(array, dtype=np.float64) for array in given))
        return jax.tree.map(lambda array, shape: np.asarray(array, dtype=shape.dtype), result, shapes)

    return jax.pure_callback(on_host, shapes, *arguments)
