"""Phase portraits against the dissertation's numbers, its printed equations, and other studies' states."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

import wucht

# 002 (5.17)-(5.18) with the corrections of docs/errata.md, over the rotor's angle.
PRINTED = {
    "states": {
        "psi": "-epsilon*u*(lambda - omega)/(omega*b) + f*(B*(2*epsilon*w - mu*s)*cos(psi)"
        " - A*(2*epsilon*w + mu*s)*sin(psi) + B*(epsilon*s*w - 2*mu))",
        "omega": "epsilon*bp*u*(lambda - omega)/(omega*b) + f*(A*(2*epsilon*bp*w - mu*br*s)*sin(psi)"
        " - B*(2*epsilon*bp*w + mu*br*s)*cos(psi) - B*(2*mu*br + epsilon*bp*s*w))",
    },
    "angles": ["psi"],
    "parameters": {"u": 1, "epsilon": 0.01, "mu": 0.01, "s": 0.75, "w": 1.3, "bp": 1, "br": 0.1, "lambda": 2, "sigma": 0.1},
    "definitions": {"A": "1 - omega^2", "B": "2*sigma*omega", "b": "bp + br", "f": "omega^3/((A^2 + B^2)*b)"},
}
RANGES = {"speed": (0.4, 2.2)}


def portrait(u: float, sigma: float = 0.1, name: str = "table-5.1", **more: Any) -> xr.Dataset:
    machine = wucht.load_machine(f"drozdetskaya-2020/{name}", {"u": u, "sigma": sigma})
    spec = {"together": True, "trajectories": 0, "ranges": RANGES} | more
    return wucht.run(wucht.PhasePortrait(**spec), machine)


def points(result: xr.Dataset) -> list[tuple[str, float]]:
    """Kinds and speeds, in order of the speed."""
    return sorted(((p["kind"], p["state"]["speed"]) for p in result.wucht.summary["fixed_points"]), key=lambda p: p[1])


def where(result: xr.Dataset, saddle: float, stable: bool = False) -> list[tuple[str, float | None]]:
    """Where the manifolds of the saddle nearest to a speed go, and at which speed."""
    s = result.wucht.summary
    speeds = [p["state"]["speed"] for p in s["fixed_points"]]
    at = min((k for k, p in enumerate(s["fixed_points"]) if p["kind"] == "saddle"), key=lambda k: abs(speeds[k] - saddle))
    ends = [m for m in s["separatrices"] if m["saddle"] == at and m["stable"] == stable]
    return [(m["end"], None if m["fixed_point"] is None else speeds[m["fixed_point"]]) for m in ends]


def test_captured_state_and_saddle() -> None:
    """cases.md: type II at u = 1; eigenvalues per angle of the rotor, with that of delta. Figure 5.5a."""
    result = portrait(1.0)
    s = result.wucht.summary
    assert s["complete"]
    assert points(result) == [
        ("stable node", pytest.approx(0.7028953, rel=1e-7)),
        ("saddle", pytest.approx(0.7674411, rel=1e-7)),
    ]
    node = next(p for p in s["fixed_points"] if p["kind"] == "stable node")
    assert [v[0] for v in node["eigenvalues_phi"]] == pytest.approx([-0.003762, -0.16462], rel=1e-4)
    assert node["transverse_phi"][0] == [pytest.approx(-0.016217, rel=1e-4), 0.0]
    assert node["stable"] and node["eigenvalues"][0][0] == pytest.approx(-0.003762 * 0.7028953, rel=2e-4)
    assert where(result, 0.767) == [("fixed point", pytest.approx(0.7028953, rel=1e-7))] * 2
    assert where(result, 0.767, stable=True) == [("left the window", None)] * 2
    assert {"fixed_points", "separatrices"} <= set(result.variables)
    assert result.separatrices.dims == ("separatrix", "state", "separatrix_sample")
    assert [str(n) for n in result.state.values] == ["psi", "speed"]


@pytest.mark.slow
def test_fixed_points_come_and_go_at_the_folds() -> None:
    """cases.md: u1* = 1.8331080, u2* = 5.8710372; beyond u2* the pair is not stable as the pendulums part."""
    found = {u: portrait(u).wucht.summary for u in (1.833107, 1.833109, 5.871036, 5.871038, 7.0)}
    assert {u: len(s["fixed_points"]) for u, s in found.items()} == {1.833107: 2, 1.833109: 0, 5.871036: 0, 5.871038: 2, 7.0: 2}
    assert all(portrait(u).wucht.summary["complete"] for u in (1.8330, 1.8332, 5.8709, 5.88))
    assert found[1.833107]["fixed_points"][0]["state"]["speed"] == pytest.approx(0.7758765, abs=3e-4)
    upper = next(p for p in found[7.0]["fixed_points"] if p["kind"] == "stable node")
    assert not upper["stable"] and upper["transverse"][0][0] > 0


@pytest.mark.parametrize(("u", "period", "low", "high"), [(3.0, 630.30303, 0.81310, 1.56264), (5.0, 1199.31590, 0, 0)])
def test_the_rotating_orbit(u: float, period: float, low: float, high: float) -> None:
    """cases.md: between the folds psi falls by a turn in this period of the rotor's angle; least and greatest speed."""
    result = portrait(u, trajectories=[{"psi": 0.0, "speed": 0.5}])
    (orbit,) = result.wucht.summary["closed_curves"]
    assert (orbit["kind"], orbit["turns"]) == ("stable", [-1.0, 0.0])
    assert orbit["period_phi"] == pytest.approx(period, rel=1e-8)
    if low:
        assert (orbit["min"]["speed"], orbit["max"]["speed"]) == (pytest.approx(low, abs=1e-5), pytest.approx(high, abs=1e-5))
    assert str(result.trajectory_end.values[0]) == "closed curve 1"


@pytest.mark.slow
def test_the_contour_breaks_before_the_lower_pair_is_gone() -> None:
    """Figure 5.8: sigma = 0.05, u2* = 2.6739155 < u1* = 5.8600817: one branch of the lower saddle goes to the upper node."""
    before, after, beyond = (portrait(u, 0.05) for u in (2.673, 4.0, 5.861))
    assert [len(points(r)) for r in (before, after, beyond)] == [2, 4, 2]
    assert len(points(portrait(2.674, 0.05))) == 4
    node = points(before)[0][1]
    assert where(before, 0.87) == [("fixed point", pytest.approx(node))] * 2
    lower, upper = (speed for kind, speed in points(after) if kind == "stable node")
    assert {end for _, end in where(after, 0.87)} == {lower, upper}
    assert {end for _, end in where(after, 1.2)} == {lower, upper}
    assert beyond.wucht.summary["closed_curves"] == []


@pytest.mark.slow
def test_the_orbit_of_the_alternative_set_ends_on_a_saddle_connection() -> None:
    """cases.md, table A.1: u1* = 2.3440611, u2* = 2.0173455; between 8.0 and 8.1."""
    counts = {u: len(points(portrait(u, name="table-a.1"))) for u in (2.0173, 2.0174, 2.34406, 2.34407)}
    assert counts == {2.0173: 2, 2.0174: 4, 2.34406: 4, 2.34407: 2}
    ends = {u: [end for end, _ in where(portrait(u, name="table-a.1"), 1.188)] for u in (8.0, 8.1)}
    assert sorted(ends[8.0]) == ["closed curve", "fixed point"]
    assert ends[8.1] == ["fixed point", "fixed point"]


@pytest.mark.slow
def test_the_printed_equations_have_the_same_portrait() -> None:
    """As a table [system]; their time is the angle of the rotor."""
    from wucht.files.user_system import equations_from

    for u in (1.0, 7.0):
        own = equations_from(PRINTED | {"set": {"u": u}})
        ranges = {"omega": (0.4, 2.2)}
        printed = wucht.run(wucht.PhasePortrait(trajectories=0, ranges=ranges), own).wucht.summary
        derived = portrait(u).wucht.summary
        assert printed["complete"]
        for a, b in zip(printed["fixed_points"], derived["fixed_points"], strict=True):
            assert a["kind"] == b["kind"]
            assert (a["state"]["psi"], a["state"]["omega"]) == pytest.approx((b["state"]["psi"], b["state"]["speed"]), rel=1e-9)
            assert np.array(a["eigenvalues"]) == pytest.approx(np.array(b["eigenvalues_phi"]), rel=1e-9)
        assert [m["to"] for m in printed["separatrices"]] == [m["to"] for m in derived["separatrices"]]


def test_a_machine_in_si_units() -> None:
    """cases.md, R1 at u = 1: captured at 70.2895 rad/s."""
    machine = wucht.load_machine("drozdetskaya-2020/r1-u1")
    result = wucht.run(wucht.PhasePortrait(together=True, trajectories=0), machine)
    assert ("stable node", pytest.approx(70.2895, abs=1e-3)) in points(result)
    assert result.fixed_points.sizes == {"fixed_point": 2, "state": 2}
    assert [str(u) for u in result.state_unit.values] == ["rad", "rad/s"]
    assert result.eigenvalues_real.attrs["units"] == "1/s"


@pytest.mark.slow
def test_two_phases_at_a_given_speed_are_a_torus() -> None:
    """000, Table 1: compensating phases 138.59, 262.82 and 221.41, 97.18 degrees, less a turn; signs of points add up to 0."""
    machine = wucht.load_machine("sperling-rollers/table-1")
    result = wucht.run(wucht.PhasePortrait(trajectories=4), machine)
    s = result.wucht.summary
    kinds = [p["kind"] for p in s["fixed_points"]]
    assert s["complete"] and kinds.count("saddle") * 2 == len(kinds)
    stable = sorted([np.degrees([p["state"]["r1"], p["state"]["r2"]]) for p in s["fixed_points"] if p["stable"]], key=list)
    assert np.array(stable) == pytest.approx(np.array([[-138.59, 97.18], [138.59, -97.18]]), abs=0.005)
    assert {m["end"] for m in s["separatrices"]} == {"fixed point"}
    assert set(map(str, result.trajectory_end.values)) <= {
        f"stable node {kinds.index('stable node') + 1 + k}" for k in range(6)
    }


def test_bodies_that_part_are_refused() -> None:
    """Equal pendulums keep together; where one is heavier they do not."""
    machine = wucht.load_machine("drozdetskaya-2020/r1", {"p2.mass": 0.13})
    with refused("study.together", "p1", "p2", code="phases-part"):
        wucht.run(wucht.PhasePortrait(together=True), machine)
    machine = wucht.load_machine("drozdetskaya-2020/r1")
    with refused("study.together", "p1.phase", "p2.phase", "drum.speed", "together = true", given=None):
        wucht.run(wucht.PhasePortrait(), machine)
    with refused("study.together", "p2", given="p"):
        wucht.run(wucht.PhasePortrait(together=["p", "p2"]), machine)
    with refused("study.kind", given="phase-portrait"):
        wucht.run(wucht.PhasePortrait(), wucht.load_machine("drozdetskaya-2020/table-3.1-laval"))


def test_many_portraits_are_one_result_and_are_resumed(tmp_path: Path) -> None:
    machine = wucht.load_machine("drozdetskaya-2020/table-5.1")
    spec = wucht.PhasePortrait(together=True, trajectories=2, along="u", values=[1.0, 3.0], ranges=RANGES)

    def stop(share: float, _what: str) -> None:
        if share > 0.6:
            raise KeyboardInterrupt

    begun = wucht.run(spec, machine, folder=tmp_path, progress=stop)
    assert not begun.wucht.finished and begun.sizes["case"] == 1
    whole, resumed = wucht.run(spec, machine), wucht.run(spec, machine, folder=tmp_path, resume=True)
    assert resumed.wucht.finished
    xr.testing.assert_identical(whole.drop_attrs(), resumed.drop_attrs())
    cases = whole.wucht.summary["cases"]
    assert [len(c["fixed_points"]) for c in cases] == [2, 0]
    assert whole.wucht.summary["along"] == "u"
    assert whole.value.values.tolist() == [1.0, 3.0]
    assert [c["closed_curves"][0]["period_phi"] if c["closed_curves"] else None for c in cases] == [
        None, pytest.approx(630.30303, rel=1e-8),
    ]  # fmt: skip
    assert len(wucht.report(whole)) > 10


def test_default_ranges_show_all_fixed_points() -> None:
    """Of equations without angles a window around those that are found; of a machine the speeds of its drive."""
    from wucht.files.user_system import equations_from

    own = equations_from({"states": {"x": "mu*x - x^3", "y": "-y"}, "parameters": {"mu": 25.0}})
    result = wucht.run(wucht.PhasePortrait(trajectories=0), own)
    assert len(result.wucht.summary["fixed_points"]) == 3
    assert result.drawn.values[0, 0] < -5 and result.drawn.values[0, 1] > 5
    machine = wucht.load_machine("drozdetskaya-2020/table-5.1", {"u": 1.0})
    drawn = wucht.run(wucht.PhasePortrait(together=True, trajectories=0), machine).drawn.values
    assert drawn == pytest.approx(np.array([[0, 4 * math.pi], [0.04, 2.3]]))
    nowhere = equations_from({"states": {"x": "1 + x^2", "y": "-y"}})
    with refused("study.ranges", "x", given=None):
        wucht.run(wucht.PhasePortrait(), nowhere)
