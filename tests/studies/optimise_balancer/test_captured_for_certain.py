"""Candidates of which some runs are captured for certain, where of the machine as it is none is: they are not eligible.

Too short runs leave most of the machine's without a verdict: the share that may be captured is larger than theirs.
"""

from __future__ import annotations

import numpy as np
import pytest

from wucht import OptimiseBalancer, load_machine, run


@pytest.mark.slow
def test_what_is_captured_for_certain_is_no_better_than_what_is_open() -> None:
    asked = OptimiseBalancer(
        vary={"damping": [0.005, 0.03]}, objectives=["residual", "peak"], until=2.0, model="slow", samples=16, population=4,
        evaluations=8, points=2, damping_curve=False,
    )  # fmt: skip
    result = run(asked, load_machine("drozdetskaya-2020/r1"))
    open_, captured = result.tried_undecided.values, result.tried_objective.sel(objective="capture-probability").values
    may_be = float(result.own_objective.sel(objective="capture-probability"))
    assert (captured - open_ > 0).all() and (captured < may_be).any()  # more than of the machine for certain, and less at most
    assert np.isfinite(result.tried_objective.sel(objective=["residual", "peak"]).values).all()
    assert result.wucht.summary["front"] == []
