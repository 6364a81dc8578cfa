"""Plans how a flat sheet with many hinges folds into a goal shape while every panel stays rigid.

>>> import foldpath as fp
>>> plan = fp.plan(fp.miura(rows=3, columns=3), bound=1e-3)
>>> plan.outcome
'planned'
>>> plan.motion.fold_angles.shape[1] == len(plan.motion.edges)
True
"""

from __future__ import annotations

import importlib
from types import ModuleType

from ._batch import batch, plan_line
from ._error import FoldpathError
from ._motion import Motion, Verdict, check, load, loads, tolerance
from ._pattern import (
    Pattern,
    closure,
    kresling,
    miura,
    quad,
    read,
    resch,
    square_twist,
    waterbomb,
    yoshimura,
)
from ._plan import Plan, plan
from ._unfold import Unfolding, unfold

__all__ = [
    "FoldpathError",
    "Motion",
    "Pattern",
    "Plan",
    "Unfolding",
    "Verdict",
    "batch",
    "check",
    "closure",
    "kresling",
    "load",
    "loads",
    "miura",
    "plan",
    "plan_line",
    "quad",
    "read",
    "resch",
    "square_twist",
    "tolerance",
    "unfold",
    "waterbomb",
    "yoshimura",
]


def __getattr__(name: str) -> ModuleType:
    """Import ``foldpath.jax`` and ``foldpath.torch`` when they are asked for: they need packages that foldpath does not."""
    if name in ("jax", "torch"):
        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
