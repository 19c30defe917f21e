"""How long an undecided run-up is advised to be: by the slowest decay that is observed, and never three times what is needed.

Needed is the shortest run whose verdict holds for all longer ones (``benchmarks.verdicts``).
"""

import pytest
from benchmarks.verdicts import MACHINES, Tried, advice_on

import wucht
from wucht import RunUp

R1 = {"p1": 0.3, "p2": -0.5}
NEEDED = 22.0  # s, of R1 with this slope, from this start; twelve machines and more: below
DRIVES = {"linear", "constant-speed", "constant-torque", "dc-separate", "dc-shunt", "dc-series", "induction", "inverter",
          "synchronous", "table"}  # fmt: skip


@pytest.mark.parametrize("until", [3.0, 4.0, 6.0, 8.0, 12.0, 20.0])
def test_a_run_that_settles_to_a_modulation_is_not_told_to_go_on_for_many_times_that(until: float) -> None:
    machine = wucht.load_machine("drozdetskaya-2020/r1", {"drive.slope": "0.00585 N m s"})
    summary = wucht.run(RunUp(until=until, start=R1), machine).wucht.summary
    assert summary["outcome"] == "unidentified"
    assert until < summary["advised_time"] <= 3 * NEEDED
    assert f"{summary['advised_time']:.3g} s" in summary["advice"]


def test_a_run_with_a_verdict_has_no_advised_time() -> None:
    machine = wucht.load_machine("drozdetskaya-2020/r1", {"drive.slope": "0.00585 N m s"})
    summary = wucht.run(RunUp(until=30.0, start=R1), machine).wucht.summary
    assert summary["outcome"] == "captured-modulated"
    assert summary["advised_time"] is None


def test_there_is_a_machine_of_each_drive_with_and_without_balancer() -> None:
    machines = [tried.machine() for tried in MACHINES]
    assert len(machines) == 12
    assert {kind for m in machines for kind in (part.kind for part in m.parts) if kind in DRIVES} == DRIVES
    assert {len(m.group(m.rotor)) > 1 for m in machines} == {True, False}


@pytest.mark.slow
@pytest.mark.parametrize("tried", MACHINES, ids=lambda tried: tried.name)
def test_advice_is_never_three_times_what_is_needed(tried: Tried) -> None:
    found = advice_on(tried)
    assert len(found.advised) >= 3
    assert found.worst <= 3.0
    assert all(until > time for time, until in found.advised)
    assert found.steps <= 5
    assert (found.outcome == "captured-modulated") == ("modulated" in tried.name)
