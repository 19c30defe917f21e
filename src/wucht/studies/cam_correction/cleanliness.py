"""How clean the corrected cam makes the output's motion, in a sentence."""

from __future__ import annotations

import math

from wucht.studies.cam_correction.prepare import Plan
from wucht.studies.cam_correction.run import Findings

CLEAN = 1e-12  # of order 1: exact but for rounding
_ENOUGH = 1e-9  # from the points
_MATTERS = 0.01  # by orders of the speed that are left out


def sentence(plan: Plan, findings: Findings) -> str:
    """The verdict: what is above order N after the correction and before, and what the points of the contour keep of it."""
    purity, (before, after) = plan.purity, findings.impurity
    endless = purity.count is None
    what = "orders differ from the law's by" if endless else f"orders above {purity.count} are"
    left = f"{'less than' if endless else 'below'} {CLEAN:.0e}" if after < CLEAN else f"{after:.2g}"
    clean = "CLEAN" if after < _ENOUGH else "NOT CLEAN"
    text = f"{clean}: {what} {left} of order {purity.reference} (before: {before:.2g})"
    shares = [purity.share(proof.recovered) for proof in findings.proofs.values() if proof.recovered is not None]
    if shares:
        more = "" if max(shares) < _ENOUGH else ", which more points make cleaner"
        text += f"; from {plan.spec.points} points of the contour {max(shares):.2g}{more}"
    lost = left_by_left_out(findings)
    return text if lost < _MATTERS else f"{text}; but the orders of the record that are left out leave about {lost:.2g}"


def left_by_left_out(findings: Findings) -> float:
    """What all orders of the record together leave that are not corrected for: about the root of the squares."""
    return math.hypot(*(one.share for one in findings.left_out))
