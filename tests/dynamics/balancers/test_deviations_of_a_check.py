"""When a check differs from the search by more than chance: thresholds from both sides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from wucht.dynamics.balancers.balancer_candidate import BalancerCandidate
from wucht.dynamics.balancers.candidates import CAPTURE, PEAK, RESIDUAL, SETTLING, CandidateResults

SEARCH = replace(CandidateResults.unknown(1, 1, 8), objectives=np.array([[10.0, 0.0, 1e-3, 0.0]]), error=np.array([0.4]))


@pytest.mark.parametrize(
    ("column", "within", "beyond"),
    [
        (SETTLING, 10 + 1.0 + 2.6 * np.hypot(0.4, 0.3) - 1e-6, 10 + 1.0 + 2.6 * np.hypot(0.4, 0.3) + 1e-6),
        (RESIDUAL, 0.99e-2 * 8e-3, 1.01e-2 * 8e-3),
        (PEAK, 1.19e-3, 1.21e-3),
        (CAPTURE, 19 / 32, 20 / 32),
    ],
)
def test_chance_explains_some_of_the_difference(column: int, within: float, beyond: float) -> None:
    """A tenth of the time and 2.6 standard errors, a hundredth of the unbalance, a fifth of the peak; of a share, one run and
    2.6 standard deviations of the difference of a share of 8 and one of 32."""
    for seen, is_off in ((within, False), (beyond, True), (np.nan, True)):
        objectives = SEARCH.objectives.copy()
        objectives[0, column] = seen
        check = replace(SEARCH, objectives=objectives, error=np.array([0.3]))
        off = BalancerCandidate(2, np.zeros(1), SEARCH, check).deviations(8e-3, 8) > 1
        assert off.tolist() == [is_off and k == column for k in range(4)]
