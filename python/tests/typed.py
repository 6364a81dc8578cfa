"""A program whose types are checked: what users write has the types that they expect."""

from __future__ import annotations

import foldpath as fp
import numpy as np
from numpy.typing import NDArray


def last_angles(file: str) -> NDArray[np.float64]:
    plan: fp.Plan = fp.plan(fp.read(file), bound=1e-2, crease={4: -45.0}, limit={7: (-30, 60)})
    motion = plan.motion
    if motion is None:
        raise RuntimeError(plan.reason)
    verdict: fp.Verdict = fp.check(motion)
    outcome: str = verdict.outcome
    print(outcome, plan.to_dict()["knots"])
    angles: NDArray[np.float64] = motion.fold_angles[-1]
    return angles


def outcomes(ids: list[str]) -> dict[str, str]:
    designs = ({"id": name, "generate": {"family": "resch"}} for name in ids)
    return {result["id"]: result["outcome"] for result in fp.batch(designs, jobs=2)}
