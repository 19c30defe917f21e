"""Bodies that are modulated together, and part: from cycle to cycle a little more."""

import math

import numpy as np
import pytest

from wucht.dynamics.verdicts.parting import _until_apart
from wucht.files.catalogue import load_machine
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import run

NEAR_ITS_LOSS = {"psi": 3.451, "delta": 0.087}


@pytest.mark.parametrize(
    ("sizes", "windows"),
    [
        (0.1 * 1.1 ** np.arange(4), math.log(10 / 1.1**3) / math.log(1.1)),
        (0.1 * 0.9 ** np.arange(4), math.inf),
        ([0.1, 0.2, 0.15, 0.3], math.inf),
        ([0.1, 0.15, 0.17, 0.175], math.inf),  # it comes to a limit
        (1e-9 * 1.1 ** np.arange(4), math.inf),  # rounding
        ([0.5, 0.8, 1.5], 0.0),
    ],
)
def test_a_difference_that_grows_alike_is_a_radian_at_last(sizes, windows):
    assert _until_apart(sizes, 1e-4) == pytest.approx(windows)


@pytest.mark.slow
@pytest.mark.parametrize(("u", "outcome"), [(3.0859, "compensated"), (3.05, "captured-modulated")])
def test_a_modulation_in_which_the_pendulums_part_slowly_is_not_the_end(u: float, outcome: str) -> None:
    """Beyond u = 3.08 it is not stable: here the pendulums have parted, and compensate, after 14,800 units of time."""
    machine = load_machine("drozdetskaya-2020/table-5.1").with_values({"u": u})
    result = run(RunUp(settled=True, start=NEAR_ITS_LOSS, model="slow"), machine)
    assert result.wucht.summary["outcome"] == outcome
    early = run(RunUp(until=5000.0, start=NEAR_ITS_LOSS, model="slow"), machine).wucht.summary
    assert early["outcome"] == ("unidentified" if outcome == "compensated" else outcome)
    assert outcome != "compensated" or 14_800 < float(early["advice"].split("until ")[1]) < 100_000
