"""Plans how a flat sheet with many hinges folds into a goal shape while every panel stays rigid.

>>> import foldpath as fp
>>> plan = fp.plan(fp.miura(rows=3, columns=3), bound=1e-3)
>>> plan.outcome
'planned'
>>> plan.motion.fold_angles.shape[1] == len(plan.motion.edges)
True
"""

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

__all__ = [
    "FoldpathError",
    "Motion",
    "Pattern",
    "Plan",
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
    "waterbomb",
    "yoshimura",
]
