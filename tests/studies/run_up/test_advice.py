"""How long an undecided run-up is advised to be: by the slowest decay that is observed, and never three times what is needed.

Needed is the shortest run whose verdict holds for all longer ones (``benchmarks.verdicts``).
"""

import pytest
from benchmarks.verdicts import MACHINES, Tried, advice_on

import wucht
from wucht import RunUp

R1 = {"p1": 0.3, "p2": -0.5}
NEEDED = 22.0  # s, of R1 with this slope, from this start; twelve machines and more: below


@pytest.mark.parametrize("until", [3.0, 8.0, 20.0])
def test_a_run_that_settles_to_a_modulation_is_not_told_to_go_on_for_many_times_that(until: float) -> None:
    machine = wucht.load_machine("drozdetskaya-2020/r1", {"drive.slope": "0.00585 N m s"})
    summary = wucht.run(RunUp(until=until, start=R1), machine).wucht.summary
    assert summary["outcome"] == "unidentified"
    assert until < summary["advised_time"] <= 3 * NEEDED
    decided = wucht.run(RunUp(until=30.0, start=R1), machine).wucht.summary if until == 20.0 else {}
    assert not decided or (decided["outcome"], decided["advised_time"]) == ("captured-modulated", None)


@pytest.mark.slow
@pytest.mark.parametrize("tried", MACHINES, ids=lambda tried: tried.name)
def test_advice_is_never_three_times_what_is_needed(tried: Tried) -> None:
    found = advice_on(tried)
    assert len(found.advised) >= 3
    assert found.worst <= 3.0
    assert all(until > time for time, until in found.advised)
    assert found.steps <= 5
    assert (found.outcome == "captured-modulated") == ("modulated" in tried.name)
