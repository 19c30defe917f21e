"""Branches of orbits of one's own equations with a closed form: ends, exponents, summary; what is refused; resuming."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipe, ellipk
from tests.interrupting import assert_same, stop_at
from tests.refusals import check_refusal, refused

from wucht import OrbitBranch, UserSystem, draw, load_machine, report, run
from wucht.files.user_system import equations_from

# r' = r (mu - r^2), phase with frequency 2 + mu: the orbit is a circle of radius sqrt mu, its exponent -2 mu.
CIRCLE = {
    "parameters": {"mu": 1.0},
    "definitions": {"s": "mu - x^2 - y^2", "w": "2 + mu"},
    "states": {"x": "s*x - w*y", "y": "w*x + s*y"},
}
ROTATION = {"parameters": {"p": 2.0}, "states": {"theta": "p - sin(theta)", "r": "-r"}, "angles": ["theta"]}


# The same where sin(pi mu) is positive, beside an angle that rests: three branches, each between two Hopf points.
ISLANDS = {
    "parameters": {"mu": 1.0},
    "definitions": {"s": "sin(pi*mu) - x^2 - y^2", "w": "2 + mu"},
    "states": {"x": "s*x - w*y", "a": "-sin(a)", "y": "w*x + s*y"},
    "angles": ["a"],
}


def own(described: dict[str, Any]) -> UserSystem:
    return equations_from(described, "a test")


@cache
def circles() -> Any:
    asked = OrbitBranch(
        along="mu", range=(-1.0, 2.0), at=1.0, values=(0.5, 1.5), start={"x": 0.5}, ranges={"x": (-1.0, 1.0), "y": (-1.0, 1.0)}
    )
    return run(asked, own(CIRCLE))


def test_circles_and_their_exponents() -> None:
    s = circles().wucht.summary
    assert [o["mu"] for o in s["orbits"]] == [0.5, 1.5]
    for orbit in s["orbits"]:
        mu = orbit["mu"]
        assert orbit["period"] == pytest.approx(2 * np.pi / (2 + mu), rel=1e-8)
        assert [orbit["min_x"], orbit["max_x"]] == pytest.approx([-np.sqrt(mu), np.sqrt(mu)], rel=1e-7)
        assert orbit["exponents"] == [pytest.approx([-2 * mu, 0.0], rel=1e-8)]
        assert not {"exponents_phi", "period_phi", "min_speed", "min_amplitude"} & orbit.keys()  # there is no rotor
        assert orbit["stable"]


def test_its_ends_are_a_hopf_point_and_the_range() -> None:
    """The parameter of the Hopf point is 0 but for rounding, and is written so; a whole search has no warnings."""
    s = circles().wucht.summary
    ends = {e["kind"]: e for e in s["ends"]}
    assert set(ends) == {"hopf", "range"}
    assert ends["hopf"]["mu"] == pytest.approx(0.0, abs=1e-8) and ends["range"]["mu"] == 2.0
    assert s["branches"][0]["stable"][0] == pytest.approx([0.0, 2.0], abs=1e-8)
    assert circles().wucht.sentence == (
        "periodic orbits at mu from 0 to 2, stable from 0 to 2; it ends at a Hopf point and at the end of the range"
    )
    assert circles().wucht.warnings == []
    assert {name for curve in OrbitBranch.curves_of_equations for name in curve} <= {*circles().variables}, "to be compared"
    assert "    end        at mu = 0 the orbit shrinks to an equilibrium: a Hopf point" in report(circles())


def test_every_orbit_of_the_circles_in_closed_form() -> None:
    """Of the whole branch and of the reported orbits, whose course over a period is stored."""
    made = circles()
    for prefix in ("", "orbit_"):
        mu = made[f"{prefix}value"].values
        assert made[f"{prefix}period"].values == pytest.approx(2 * np.pi / (2 + mu), rel=1e-4)
        assert f"{prefix}period_phi" not in made
        assert made[f"{prefix}max_x"].values == pytest.approx(np.sqrt(mu), rel=1e-3, abs=1e-6)
        assert made[f"{prefix}min_x"].values == pytest.approx(-np.sqrt(mu), rel=1e-3, abs=1e-6)
        assert made[f"{prefix}exponent_re"].values[0] == pytest.approx(-2 * mu, rel=1e-3, abs=1e-6)
    assert made.orbit_time.values[:, -1] == pytest.approx(made.orbit_period.values)
    assert (made.orbit_time.values[:, 0] == 0).all()
    assert made.orbit_states.dims == ("orbit", "state", "place") and made.state.values.tolist() == ["x", "y"]
    assert np.array_equal(made.orbit_states.sel(state="x").values, made.orbit_state.values)
    radius = np.hypot(*np.moveaxis(made.orbit_states.values, 1, 0))
    assert radius == pytest.approx(np.sqrt(made.orbit_value.values)[:, None] * np.ones(radius.shape[1]), rel=1e-6)


@cache
def islands() -> Any:
    values = tuple(2 * k + share for k in range(3) for share in np.linspace(0.2, 0.8, 6).tolist())
    asked = OrbitBranch(along="mu", range=(-0.5, 5.5), at=(0.5, 2.5, 4.5), values=values, start={"x": 0.5})
    return run(asked, own(ISLANDS))


@pytest.mark.slow
def test_each_orbit_has_the_number_of_its_branch() -> None:
    made = islands()
    assert made.wucht.sentence.endswith("; both ends are a Hopf point; 2 more branches")
    for prefix, count in (("", len(made.value)), ("orbit_", 18), ("end_", 6)):
        mu, branch = made[f"{prefix}value"].values, made[f"{prefix}branch"].values
        assert len(mu) == count and np.array_equal(np.floor((mu + 1e-6) / 2), branch)
    assert [(b["range"][0] // 2, b["stable"][0]) for b in made.wucht.summary["branches"]] == [
        (k, pytest.approx([2 * k, 2 * k + 1], abs=1e-6)) for k in range(3)
    ]
    largest = np.maximum(-1.0, -2 * np.sin(np.pi * made.orbit_value.values))  # the angle's is -1
    assert made.orbit_exponent_re.values[0] == pytest.approx(largest, rel=1e-6)
    lines = report(made)
    assert sum(line.startswith("  orbit ") for line in lines) == 16 and lines[-2] == "  and 2 more orbits: see the Dataset"


def test_a_value_without_an_orbit_is_told() -> None:
    asked = OrbitBranch(along="mu", range=(-0.5, 3.5), at=(0.5, 2.5), values=(1.5, 2.5, 1.25), start={"x": 0.5})
    made = run(asked, own(ISLANDS))
    assert made.wucht.sentence.endswith("; one more branch")
    assert made.wucht.warnings == ["there is no orbit of a known branch at mu = 1.5, 1.25"]


def test_a_libration_turns_no_angle_and_a_damped_swing_is_a_complex_exponent() -> None:
    """H = v^2/2 - cos q tends to E: the pendulum's period 4 K((1 + E)/2). Beside it a swing that decays as exp(-0.3 t)."""
    described = {
        "parameters": {"E": -0.5},
        "definitions": {"H": "v^2/2 - cos(q)"},
        "states": {"q": "v", "v": "-sin(q) + v*(E - H)", "z": "-0.3*z - 0.7*u", "u": "0.7*z - 0.3*u"},
        "angles": ["q"],
    }
    made = run(
        OrbitBranch(along="E", range=(-0.55, -0.45), at=-0.5, values=(-0.5,), start={"q": 0.5}, show="q"), own(described)
    )
    (orbit,) = made.wucht.summary["orbits"]
    assert orbit["period"] == pytest.approx(4 * ellipk(0.25), rel=1e-8)
    assert [orbit["min_q"], orbit["max_q"]] == pytest.approx([-np.pi / 3, np.pi / 3], rel=1e-7)
    assert report(made)[2].endswith("; all angles return")
    beat = 2 * np.pi / orbit["period"] - 0.7  # but for whole turns in a period
    swings = sorted(e for e in orbit["exponents"] if e[1])
    assert swings == [pytest.approx([-0.3, sign * beat], rel=1e-6) for sign in (-1, 1)]
    stored = np.array([made.orbit_exponent_re.values[:, 0], made.orbit_exponent_im.values[:, 0]])
    assert stored.T.tolist() == orbit["exponents"]
    # Liouville: the product of the multipliers is exp of the integral of the trace over a period. Here it is E - H - v^2 - 0.6,
    # and the integral of v^2 that of v over q, the area 16 (E(m) - (1 - m) K(m)) of the pendulum's orbit, m = (1 + E)/2 = 1/4.
    area = 16 * (ellipe(0.25) - 0.75 * ellipk(0.25))
    multipliers = [complex(*pair) for pair in orbit["multipliers"]]
    assert np.prod(multipliers) == pytest.approx(np.exp(-area - 0.6 * orbit["period"]), rel=1e-8)
    by_swing = np.exp((-0.3 + 0.7j) * orbit["period"])
    assert multipliers[0] == pytest.approx(by_swing if by_swing.imag > 0 else by_swing.conjugate(), rel=1e-6)
    stored = made.orbit_multiplier_re.values[:, 0] + 1j * made.orbit_multiplier_im.values[:, 0]
    assert stored.tolist() == multipliers


def test_branches_are_the_table_of_that_name() -> None:
    result = circles()
    with pytest.warns(FutureWarning, match="branch_points"):
        branches = result.wucht.branches
    assert branches.equals(result.wucht.table("branches")) and branches["begun"].tolist() == ["a run at mu = 1"]
    assert len(result.wucht.branch_points) == result.sizes["point"]


def test_the_law_of_a_saddle_connection_has_the_rate_of_the_saddle() -> None:
    """The leaf x^2 (1 - x) = y^2 returns to the origin where mu = 0, whose eigenvalues are a + 2 and a - 2 (Sandstede)."""
    described = {
        "parameters": {"mu": -0.1, "a": -0.5},
        "states": {"x": "a*x + 2*y - a*x^2", "y": "2*x + (a + mu)*y - 3*x^2 - 1.5*a*x*y"},
    }
    made = run(OrbitBranch(along="mu", range=(-0.3, 0.2), at=-0.1, values=(-0.1,), start={"x": 0.6}), own(described))
    assert made.wucht.sentence.endswith("; it ends at a Hopf point and at a saddle connection")
    hopf, connection = made.wucht.summary["ends"]
    assert (hopf["laws"], connection["kind"]) == (None, "saddle-connection")
    law = connection["laws"]["connection"]
    assert law["rate"] == pytest.approx(1.5, rel=2e-3) and law["critical"] == pytest.approx(0.0, abs=1e-8)
    assert connection["state"] == {"x": pytest.approx(0.0, abs=1e-9), "y": pytest.approx(0.0, abs=1e-9)}
    assert sorted(e[0] for e in connection["eigenvalues"]) == pytest.approx([-2.5, 1.5], abs=1e-6)
    assert made.end_residual.values[1] == pytest.approx(
        [connection["laws"][name]["residual"] for name in ("saddle-node", "connection")]
    )
    assert np.isnan(made.end_residual.values[0]).all()


@pytest.mark.slow
def test_orbits_of_a_rotor() -> None:
    """002, table 5.1 at u = 3, both pendulums together: period, speeds, exponent, also over the angle of the rotor."""
    asked = OrbitBranch(along="u", range=(2.9, 3.1), at=3.0, values=(3.0,), together=True)
    made = run(asked, load_machine("drozdetskaya-2020/table-5.1"))
    (orbit,) = made.wucht.summary["orbits"]
    assert [warning.partition(":")[0] for warning in made.wucht.warnings] == ["no machine has these parameters"]
    assert orbit["period_phi"] == pytest.approx(630.30303, rel=1e-7)
    per_angle = orbit["period"] / orbit["period_phi"]
    assert orbit["exponents_phi"] == [[pytest.approx(per_angle * part) for part in e] for e in orbit["exponents"]]
    assert (made.mean_speed.values > 0).all() and (made.period_phi.values > 0).all()
    assert made.period_phi.values == pytest.approx((made.period * made.mean_speed).values)
    assert made.wucht.sentence.startswith("modulated motions at u from 2.9 to 3.1, stable within their section from 2.9 to 3.1")
    lines = report(made)
    assert lines[2].endswith("; turns a period: psi -1")
    assert "(630.30303 of the rotor's angle), 0.8131 to 1.5626, largest exponent -0.30692, stable" in lines[5]


def test_orbits_are_drawn_from_their_least_value_over_one_period() -> None:
    """x = -sqrt(mu) cos(2 + mu) t, and as stored, the period repeated; beside that in the plane of two states, no angles."""
    made = circles()
    lines = draw(made).axes[1].get_lines()
    assert len(lines) == 2
    for k, (line, mu) in enumerate(zip(lines, made.orbit_value.values, strict=True)):
        t, x = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
        turned = (2 + mu) * t
        assert t[0] == 0.0 and turned[-1] == pytest.approx(2 * np.pi, rel=1e-4) and (np.diff(t) > 0).all()
        assert x == pytest.approx(-np.sqrt(mu) * np.cos(turned), abs=0.05 * np.sqrt(mu))
        time, stored = made.orbit_time.values[k], made.orbit_state.values[k]
        begin = time[stored[:-1].argmin()]
        assert x == pytest.approx(np.interp(begin + t / t[-1] * time[-1], time, stored, period=time[-1]), abs=1e-9)
    for made, second in ((circles(), 1), (islands(), 2)):
        of_first = made.orbit_states.values[made.orbit_branch.values == 0]
        for line, states in zip(draw(made).axes[3].get_lines(), of_first, strict=True):
            assert np.array_equal(line.get_xdata(), states[0]) and np.array_equal(line.get_ydata(), states[second])


def test_unstable_orbits_are_dashed() -> None:
    """r' = r (mu + r^2): no run comes to these circles, which shrink to the Hopf point mu = 0 from below."""
    described = CIRCLE | {"definitions": {"s": "mu + x^2 + y^2", "w": "2 + mu"}}
    box = {"x": (-1.0, 1.0), "y": (-1.0, 1.0)}
    made = run(OrbitBranch(along="mu", range=(-0.5, 0.2), values=(-0.25,), ranges=box, show="y"), own(described))
    assert "nowhere stable; it ends at the end of the range and at a Hopf point" in made.wucht.sentence
    assert report(made)[-2].endswith("y -0.5 to 0.5, largest exponent 0.5, unstable")
    phase_space = draw(made).axes[3]
    assert (phase_space.get_xlabel(), phase_space.get_ylabel()) == ("y", "x")
    assert [line.get_linestyle() for line in phase_space.get_lines()] == ["--"]


def test_a_winding_orbit_ends_at_a_saddle_node() -> None:
    """T = 2 pi/sqrt(p^2 - 1), and no end within the range the other way."""
    made = run(OrbitBranch(along="p", range=(0.0, 3.0), at=2.0, values=(2.0,), longest=100.0), own(ROTATION))
    s = made.wucht.summary
    assert s["orbits"][0]["period"] == pytest.approx(2 * np.pi / np.sqrt(3), rel=1e-8)
    assert s["branches"][0]["winding"] == {"theta": 1}
    assert report(made)[2].endswith("; turns a period: theta +1")
    assert [(e["kind"], e["p"]) for e in s["ends"]] == [
        ("saddle-node-on-orbit", pytest.approx(1.0, abs=1e-9)),
        ("range", 3.0),
    ]


def test_where_there_is_none_a_sentence_says_what_was_found() -> None:
    """At p < 1 the rotation stands."""
    r = run(OrbitBranch(along="p", range=(0.2, 0.8), at=(0.8, 0.2, 0.8), until=200.0), own(ROTATION))
    assert not r.wucht.summary["orbits"]
    assert [t["p"] for t in r.wucht.summary["tried"]] == [0.8, 0.2], "the ends of the range are in it"
    assert "no modulated motion was found" in r.attrs["sentence"]
    assert "settles in a steady state" in r.attrs["sentence"]
    assert len(draw(r).axes) == 1  # no panels of orbits that there are not
    assert report(r)


def test_a_hopf_point_begins_a_branch_where_no_run_finds_an_orbit() -> None:
    """From rest at the origin nothing moves; the Hopf point is found among the equilibria."""
    asked = OrbitBranch(along="mu", range=(-1.0, 1.0), values=(0.5,), ranges={"x": (-1.0, 1.0), "y": (-1.0, 1.0)})
    s = run(asked, own(CIRCLE)).wucht.summary
    assert s["orbits"][0]["period"] == pytest.approx(2 * np.pi / 2.5, rel=1e-8)
    assert "Hopf point" in s["branches"][0]["begun"]


def test_a_relaxation_oscillation() -> None:
    """x'' - m (1 - x^2) x' + x = 0 at m = 30, where x' is large in a thousandth of a period; its period from SciPy (Radau)."""
    described = {"parameters": {"m": 30.0}, "states": {"x": "v", "v": "m*(1 - x^2)*v - x"}}
    asked = OrbitBranch(along="m", range=(29.9, 30.1), at=30.0, values=(30.0,), start={"x": 0.5})
    (orbit,) = run(asked, own(described)).wucht.summary["orbits"]
    assert orbit["period"] == pytest.approx(50.54368648, rel=1e-9)


def test_a_run_takes_no_longer_than_it_may() -> None:
    """A period is 2 pi/3: it is seen several times in a run of 30, and not at all in one of 1."""
    asked: dict[str, Any] = {"along": "mu", "range": (0.9, 1.1), "at": 1.0, "values": (1.0,), "start": {"x": 0.5}}
    (orbit,) = run(OrbitBranch(**asked, until=30.0), own(CIRCLE)).wucht.summary["orbits"]
    assert orbit["period"] == pytest.approx(2 * np.pi / 3, rel=1e-8)
    (tried,) = run(OrbitBranch(**asked, until=1.0), own(CIRCLE)).wucht.summary["tried"]
    assert tried["found"] == "at mu = 1 it has settled neither in a steady state nor on an orbit after 1"


@pytest.mark.parametrize(
    "keys",
    [
        {"along": "nu"}, {"range": (2.0, 1.0)}, {"at": (1.0, 5.0)}, {"values": (0.05,)}, {"values": ()}, {"show": "z"},
        {"start": {"z": 1.0}}, {"start": {"x": "much"}}, {"together": True}, {"inertia": True},
    ],
)  # fmt: skip
def test_what_is_refused(keys: dict[str, Any]) -> None:
    asked = {"along": "mu", "range": (0.1, 1.0)} | keys
    check_refusal(f"orbit-branch: {keys}", lambda: run(OrbitBranch(**asked), own(CIRCLE)))


def test_equations_that_depend_on_time_are_refused() -> None:
    with refused("system", given=None):
        run(OrbitBranch(along="a", range=(0.0, 1.0)), own({"parameters": {"a": 1.0}, "states": {"x": "a*cos(t) - x"}}))


def test_keys_of_systems_are_refused_for_a_machine() -> None:
    with refused("study.show", given="x", code="system-only"):
        run(OrbitBranch(along="u", range=(1.0, 2.0), show="x"), load_machine("drozdetskaya-2020/table-5.1"))


def test_an_interrupted_study_goes_on_where_it_was(tmp_path: Path) -> None:
    """Ctrl-C before the second orbit: a valid result, and the same numbers in the end."""
    asked = OrbitBranch(along="mu", range=(0.4, 1.6), at=1.0, values=(0.5, 1.5), start={"x": 0.5})
    part = run(asked, own(CIRCLE), folder=tmp_path, progress=stop_at(1, "exponents at mu = 1.5"))
    assert not part.attrs["finished"]
    assert [o["mu"] for o in part.wucht.summary["orbits"]] == [0.5]
    assert part.wucht.warnings[0] == "the search is not finished"
    assert draw(part).axes
    assert_same(run(asked, own(CIRCLE), folder=tmp_path, resume=True), run(asked, own(CIRCLE)))


def test_before_the_first_orbit() -> None:
    """Steady states are followed before."""
    box = {"x": (-1.0, 1.0), "y": (-1.0, 1.0)}
    part = run(OrbitBranch(along="mu", range=(-1.0, 2.0), ranges=box), own(CIRCLE), progress=stop_at(1, "a run at mu"))
    assert part.wucht.sentence == "the study was interrupted before the first orbit"
    assert part.wucht.warnings[0] == "the search is not finished"
    assert part.sizes["steady"] and not part.sizes["point"]


# AUTO's demo plp at S0 = 111 (AUTO-07P manual, 2007): a closed branch.
ISOLA = {
    "parameters": {"rho": 4.0},
    "definitions": {"R": "s*a/(1 + s + 0.1*s^2)"},
    "states": {"s": "111 - s - rho*R", "a": "0.2*(500 - a) - rho*R"},
}


@cache
def isola() -> Any:
    return run(OrbitBranch(along="rho", range=(2.0, 6.0), at=4.0, start={"s": 100.0, "a": 300.0}, until=300.0), own(ISOLA))


def test_a_closed_branch_is_described_once() -> None:
    s = isola().wucht.summary
    assert [(p["kind"], p["rho"]) for p in s["special_points"]] == [
        ("fold", pytest.approx(4.7221252364, abs=1e-9)),
        ("fold", pytest.approx(2.9862948102, abs=1e-9)),
    ]
    assert [e["kind"] for e in s["ends"]] == ["closed"]
    assert s["sentence"].endswith("; it is closed")
    (branch,) = s["branches"]
    assert branch["stable"] == [pytest.approx([2.9862948102, 4.7221252364], abs=1e-6)]
    passed = [o for o in s["orbits"] if not o["kind"] and abs(o["rho"] - s["orbits"][2]["rho"]) < 1e-9]
    assert len(passed) == 2
    at_folds = isola().unstable.values[isola().at_special.values == 1]
    assert at_folds.tolist() == [0, 0], "no disturbance grows by rounding"


@pytest.mark.parametrize(
    ("states", "start", "reached", "is_family"),
    [
        ({"x": "v", "v": "-k*x"}, {"x": 1.0}, "it is periodic with period 6.28319, one of a family", True),
        ({"x": "v", "v": "-k*x"}, {}, "rests at an equilibrium about which disturbances neither grow nor decay", True),
        ({"x": "v", "v": "-k*x - 0.2*v"}, {"x": 1.0}, "it settles in a steady state", False),
        ({"x": "v", "v": "k*x - x^3 - 0.3*v"}, {}, "it rests at an unstable equilibrium", False),
    ],
)
def test_families_and_unstable_rest_are_no_steady_states(
    states: dict[str, str], start: dict[str, float], reached: str, is_family: bool
) -> None:
    """An oscillator without damping, with it, and one that starts between its wells; at k = 1."""
    question = OrbitBranch(along="k", range=(0.5, 2.0), at=1.0, start=start)
    sentence = run(question, own({"parameters": {"k": 1.0}, "states": states})).attrs["sentence"]
    assert reached in sentence
    assert sentence.startswith("the motions are families" if is_family else "no modulated motion was found")


def test_a_frequency_response_folds_where_a_multiplier_is_one() -> None:
    """Softening Duffing oscillator: its folds by shooting; there SciPy's orbit returns, and so does a change of it."""
    described = {
        "parameters": {"eta": 0.5, "D": 0.05, "g": -1.0, "w": 0.05},
        "states": {"x": "v", "v": "w*cos(p) - 2*D*v - x - g*x^3", "p": "eta"}, "angles": ["p"],
    }  # fmt: skip
    result = run(OrbitBranch(along="eta", range=(0.8, 1.0), at=0.82, values=(0.88,)), own(described))
    folds = result.wucht.summary["special_points"]
    assert [(p["kind"], p["eta"]) for p in folds] == [
        ("fold", pytest.approx(0.89277921, abs=5e-9)), ("fold", pytest.approx(0.8627056, abs=5e-9)),
    ]  # fmt: skip

    def rates(t: float, y: np.ndarray, eta: float) -> list[float]:
        x, v, p, *change = y
        stiffness = 3 * x**2 - 1
        by_x, by_v = (change[k : k + 2] for k in (0, 2))
        return [
            v, 0.05 * np.cos(p) - 0.1 * v - x + x**3, eta,
            by_x[1], stiffness * by_x[0] - 0.1 * by_x[1], by_v[1], stiffness * by_v[0] - 0.1 * by_v[1],
        ]  # fmt: skip

    for k in np.flatnonzero(result.orbit_kind.values == "fold"):
        eta, start = float(result.orbit_value.values[k]), result.orbit_states.values[k, :, 0]
        y = solve_ivp(
            rates, (0.0, 2 * np.pi / eta), [*start, 1.0, 0.0, 0.0, 1.0], args=(eta,), method="DOP853", rtol=1e-11, atol=1e-13
        ).y
        assert y[:2, -1] == pytest.approx(start[:2], abs=1e-7)
        assert np.linalg.eigvals(y[3:, -1].reshape(2, 2)).real.max() == pytest.approx(1.0, abs=1e-5)
