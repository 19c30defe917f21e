"""How clean the corrected cam makes the output's motion, in a sentence."""

from __future__ import annotations

from wucht.studies.cam_correction.prepare import Plan
from wucht.studies.cam_correction.run import Findings

CLEAN = 1e-12  # of order 1: exact but for rounding
_ENOUGH = 1e-9  # from the points


def sentence(plan: Plan, findings: Findings) -> str:
    """The verdict: what is above order N after the correction and before, and what the points of the contour keep of it."""
    purity, (before, after) = plan.purity, findings.impurity
    endless = purity.count is None
    what = "orders differ from the law's by" if endless else f"orders above {purity.count} are"
    left = f"{'less than' if endless else 'below'} {CLEAN:.0e}" if after < CLEAN else f"{after:.2g}"
    clean = "CLEAN" if after < _ENOUGH else "NOT CLEAN"
    text = f"{clean}: {what} {left} of order {purity.reference} (before: {before:.2g})"
    shares = [purity.share(found) for found in findings.recovered.values()]
    if not shares:
        return text
    worst = max(shares)
    points = f"from {plan.spec.points} points of the contour {worst:.2g}"
    return f"{text}; {points}" + ("" if worst < _ENOUGH else ", which more points make cleaner")
