"""O. Drozdetskaya, dissertation, KIT Karlsruhe 2020: figures 5.6, 5.7, A.3, and section 6.2.

Numbers computed independently from the corrected equations (SciPy at 1e-11, AUTO-07p), met to all digits given.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from wucht import OrbitBranch, run
from wucht.files.catalogue import load_machine
from wucht.studies.study_file import read_study

PERIODS = {2.0: 1665.34645, 3.0: 630.30303, 4.0: 721.60711, 5.0: 1199.31590}
SPEEDS = {2.0: (0.77291, 1.42312), 3.0: (0.81310, 1.56264)}
DELTA = {2.0: -0.01969, 3.5: 0.00839}


@cache
def answer(name: str) -> dict[str, Any]:
    study = read_study(f"drozdetskaya-2020/figure-{name}")
    return run(study.spec, study.subject).wucht.summary


def ends(summary: dict[str, Any]) -> list[tuple[str, float]]:
    return sorted(((e["kind"], e["u"]) for e in summary["ends"]), key=lambda end: end[1])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["5.6", "5.7"])
def test_periods_and_speeds_of_table_5_1(name: str) -> None:
    orbits = {o["u"]: o for o in answer(name)["orbits"]}
    for u, period in PERIODS.items():
        assert orbits[u]["period_phi"] == pytest.approx(period, rel=1e-7)
    for u, (low, high) in SPEEDS.items():
        assert orbits[u]["min_speed"] == pytest.approx(low, abs=6e-6)
        assert orbits[u]["max_speed"] == pytest.approx(high, abs=6e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["5.6", "5.7"])
def test_both_ends_of_table_5_1_are_saddle_nodes_on_the_orbit(name: str) -> None:
    """u1* and u2*; the law of the period alone gives them within its own error."""
    summary = answer(name)
    expected = [("saddle-node-on-orbit", 1.8331080), ("saddle-node-on-orbit", 5.8710372)]
    assert ends(summary) == [(kind, pytest.approx(u, abs=6e-8)) for kind, u in expected]
    for end in summary["ends"]:
        law = end["laws"]["saddle-node"]
        assert law["critical"] == pytest.approx(end["u"], abs=3 * law["error"])
        assert law["residual"] < end["laws"]["connection"]["residual"] / 10


@pytest.mark.slow
def test_delta_of_figure_5_7() -> None:
    """The exponent of delta by phi, and where it passes zero."""
    summary = answer("5.7")
    orbits = {o["u"]: o for o in summary["orbits"]}
    for u, exponent in DELTA.items():
        assert orbits[u]["exponents_phi"][0] == pytest.approx([exponent, 0.0], abs=6e-6)
    special = [p for p in summary["special_points"] if p["kind"] == "branch-point"]
    assert [p["u"] for p in special] == [pytest.approx(3.0800128, abs=6e-8)]
    assert summary["branches"][0]["stable"] == [pytest.approx([1.8331080, 3.0800128], abs=1e-6)]


@pytest.mark.slow
def test_figure_a_3_ends_on_a_saddle_connection() -> None:
    (first, u1), (last, u3) = ends(answer("a.3"))
    assert (first, last) == ("saddle-node-on-orbit", "saddle-connection")
    assert u1 == pytest.approx(2.3440611, abs=6e-8)
    assert 8.0 < u3 < 8.1


def test_the_limits_of_section_6_2() -> None:
    """Figure 6.7 (b), footnote 2: s = 1, p = 0.99, beta_r = 0.2, beta_p = 2; the pendulums together: u from 2.150 to 5.161."""
    exciter = {"mu": 0.1, "w": 0.899, "lambda": 2.0, "s": 1.0, "beta_r": 0.2, "beta_p": 2.0, "sigma": 0.1}
    machine = load_machine("drozdetskaya-2020/table-5.1").with_unchecked_values(exciter)
    asked = OrbitBranch(along="u", range=(1.0, 8.0), at=(3.0,), together=True, values=(3.0,))
    found = [u for _, u in ends(run(asked, machine).wucht.summary)]
    assert found == [pytest.approx(2.150, abs=6e-4), pytest.approx(5.161, abs=6e-4)]


@pytest.mark.slow
def test_delta_loses_stability_subcritically() -> None:
    """The branch with delta that leaves at u = 3.0800128 goes to smaller u, unstable, and has the same period there."""
    asked = OrbitBranch(along="u", range=(2.4, 3.3), at=(2.5,), values=(3.07,), switch=True)
    summary = run(asked, load_machine("drozdetskaya-2020/table-5.1")).wucht.summary
    first, other = summary["branches"]
    assert "branch point at u = 3.08001" in other["begun"]
    assert other["range"][1] == pytest.approx(3.0800128, abs=1e-3)
    assert other["range"][1] < first["range"][1]
    assert not other["stable"]
    together, apart = sorted((o for o in summary["orbits"] if o["u"] == 3.07), key=lambda o: o["branch"])
    assert together["stable"]
    assert not apart["stable"]
    assert apart["period"] == pytest.approx(together["period"], rel=0.05)
