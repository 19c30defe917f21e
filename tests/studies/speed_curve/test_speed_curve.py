"""The study ``speed-curve``: refusals, families, branch points, ends, other subjects, a second parameter, interruption."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from tests.refusals import check_refusal, refused

from auto_demos import AB
from wucht import Machine, SpeedCurve, System, UserSystem, draw, load_machine, report, run
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.files.building import machine_from
from wucht.numerics.flow.jacobian import Jacobian

TABLE = "drozdetskaya-2020/table-5.1"
LINEAR = {"kind": "linear", "slope": 0.01, "no_load_speed": 200.0}


def balanced(balls: int = 3, **drive: Any) -> Machine:
    ball = {"kind": "pendulum", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 0.05}
    return machine_from({
        "carrier": {"mass": 1.0, "directions": "xy", "stiffness": 1e5, "damping": 200.0},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03},
            *({"name": f"b{i}"} | ball for i in range(balls)),
        ],
        "drive": {k: v for k, v in ({"on": "drum", **LINEAR} | drive).items() if v is not None},
    })  # fmt: skip


def summary(subject: Any, **asked: Any) -> dict[str, Any]:
    return run(SpeedCurve(**asked), subject).wucht.summary


REFUSED: list[tuple[str, dict[str, Any]]] = [
    (TABLE, {"along": "v", "range": [0, 1]}), (TABLE, {"along": "u", "range": [1, 0]}),
    (TABLE, {"along": "u", "range": [2, 2]}), (TABLE, {"along": "u", "range": [-1, 2]}),
    (TABLE, {"along": "u", "range": ["1 kg", 2]}), (TABLE, {"along": "u", "range": [0, 1], "points": 0}),
    (TABLE, {"along": "u", "range": [0, 1], "only": ["beside"]}),
    (TABLE, {"along": "u", "range": [0, 1], "second": "u", "second_values": [1]}),
    (TABLE, {"along": "u", "range": [0, 1], "second": "sigma"}),
    (TABLE, {"along": "u", "range": [0, 1], "second_values": [1]}),
    (TABLE, {"along": "u", "range": [0, 1], "second": "sigma", "second_range": [0.2, 0.3]}),
    (TABLE, {"along": "u", "range": [0, 1], "second": "sigma", "second_values": [-1]}),
    (TABLE, {"along": "u", "range": [0, 1], "second": "sigma", "second_values": []}),
    (TABLE, {"along": "u", "range": [0, 1], "show": "p3.phase"}),
    (TABLE, {"along": "u", "range": [0, 1], "ranges": {"x": [0, 1]}}),
    (TABLE, {"along": "u", "range": [0, 1], "ranges": {"x": [1, 0]}}),
    ("sperling-vibration/figure-2a", {"along": "drive.slope", "range": [1e-5, 2e-5]}),
    ("practice/laundry-drum", {"along": "drive.voltage", "range": [1, 2]}),
]  # fmt: skip


@pytest.mark.parametrize(("name", "asked"), REFUSED)
def test_bad_input_is_refused(name: str, asked: dict[str, Any]) -> None:
    check_refusal(f"speed-curve of {name}: {asked}", lambda: summary(load_machine(name), **asked))


def test_machines_without_steady_operation_are_refused_with_the_reason() -> None:
    still = balanced(0, no_load_speed=0.0)
    with refused("study.range", given=[0.01, 0.02]):
        summary(still, along="drive.slope", range=[0.01, 0.02])
    prescribed = balanced(0, slope=None, no_load_speed=None, kind="constant-speed", speed=100.0)
    with refused("machine.drive", "study.kind", "response", given=None):
        summary(prescribed, along="drive.speed", range=[50, 150])


@pytest.mark.slow
def test_a_pitchfork_of_compensation_and_together() -> None:
    """Two equal pendulums just compensate the rotor at s = 2: type I begins there, and type II is stable beyond."""
    r = run(SpeedCurve(along="s", range=[0.5, 4.0]), load_machine(TABLE))
    s = r.wucht.summary
    (point,) = [p for p in s["special_points"] if p["kind"] == "branch-point"]
    assert (point["s"], point["speed"]) == pytest.approx((2.0, 2.0), abs=1e-9)
    assert (point["state"]["psi"], point["state"]["delta"]) == pytest.approx((math.pi, 0.0), abs=1e-6)
    stable = [(b["type"], b["stable"]) for b in s["branches"] if b["stable"]]
    assert ("I", [pytest.approx([0.5, 2.0], abs=1e-9)]) in stable
    assert ("II", [pytest.approx([2.0, 4.0], abs=1e-9)]) in stable
    # Both halves of type I are one branch, equal pendulums being exchanged; (5.6): delta = 2 arccos(s/2) all along.
    (one,) = [k for k, t in enumerate(r.branch_type.values) if t == "I"]
    at = r.branch.values == one
    delta = np.abs(r.state.values[0, at] - r.state.values[1, at])
    assert np.abs(np.cos(delta / 2)) == pytest.approx(r.value.values[at] / 2, abs=1e-9)


@pytest.mark.slow
def test_families_are_followed_modulo_the_family() -> None:
    """Three equal pendulums: a family of dimension 1 compensates, at the speed without vibration."""
    machine = balanced(3, no_load_speed=180.0).with_unchecked_values({"drum.bearing_damping": 1e-4})
    r = run(SpeedCurve(along="drive.slope", range=[1e-4, 0.05], points=3), machine)
    s = r.wucht.summary
    (family,) = [b for b in s["branches"] if b["family_dimension"]]
    assert family["name"] == "compensating" and family["family_dimension"] == 1 and family["range"] == [1e-4, 0.05]
    assert sum("form families of dimension 1" in w for w in r.wucht.warnings) == 1
    at = r.branch.values == s["branches"].index(family)
    slope = r.value.values[at]
    assert r.speed.values[at] == pytest.approx(180.0 * slope / (slope + 1e-4), rel=1e-10)
    assert (r.amplitude.values[at] == 0).all()
    # Its members gain their stability above the natural frequency, one after another, each by a Hopf bifurcation: so the whole
    # Jacobian of the averaged equations says too, in which one more eigenvalue, along the family, is zero.
    limits = {p["kind"]: p for p in s["special_points"] if p["kind"] != "fold"}
    some, all_ = (limits[kind]["drive.slope"] for kind in ("some-stable", "all-stable"))
    assert len(limits) == 2 and all(0.99 < p["speed"] / math.sqrt(1e5 / 10.3) < 1.1 for p in limits.values())
    assert family["stable"] == [[all_, 0.05]] and family["partly_stable"] == [[some, all_]] and some < 0.99 * all_
    averaged = averaged_equations_of(machine)
    system = averaged.system
    jacobian = Jacobian.of(system)

    def growth(state: dict[str, float], slope: float) -> np.ndarray:
        values = system.values(machine.values | {"drive.slope": slope})
        return np.linalg.eigvals(jacobian.values_at([state[name] for name in system.state_names], values)[1])

    for point in limits.values():
        eigenvalues = growth(point["state"], point["drive.slope"])
        eigenvalues = eigenvalues[np.argsort(np.abs(eigenvalues.real))]
        assert np.abs(eigenvalues[:3].real) == pytest.approx([0.0] * 3, abs=1e-6)
        assert np.sort(eigenvalues[:3].imag) == pytest.approx([-point["frequency"], 0.0, point["frequency"]], abs=1e-6)
    # Members that are not among those looked at: all are stable beyond the stretch, none before it, and some within it.
    for slope, share in ((0.98 * some, 0.0), ((some + all_) / 2, 0.5), (1.02 * all_, 1.0)):
        speed, stable = 180.0 * slope / (slope + 1e-4), list[bool]()
        for turned in np.linspace(0, 2 * np.pi, 40):
            # One pendulum anywhere, the other two close the polygon: 0.009 + 0.01 (e^ia + e^ib + e^ic) = 0.
            left = -(0.009 + 0.01 * np.exp(1j * turned))
            if abs(left) < 0.02:
                half = math.acos(abs(left) / 0.02)
                phases = [turned, np.angle(left) + half, np.angle(left) - half]
                state = dict(zip(system.state_names, averaged.steady_state(speed, [0.0, *phases]), strict=True))
                found = growth(state, slope)
                stable.append(bool(np.sort(found.real)[-2] < 0 if np.abs(found.real).min() < 1e-6 else np.max(found.real) < 0))
        assert len(stable) > 15 and (0 < np.mean(stable) < 1 if share == 0.5 else np.mean(stable) == share)
    assert np.isnan(r.exponent_re.values[-1, at]).all() and np.isfinite(r.exponent_re.values[-2, at]).all()
    (own,) = [x for x in s["states"] if x["family_dimension"]]
    assert own["stable"] and own["stable_share"] == 1.0 and own["speed"] == pytest.approx(180 / 1.01, rel=1e-12)
    assert any("family of dimension 1" in line for line in report(r))


@pytest.mark.slow
def test_a_family_ends_where_the_unbalances_cannot_compensate() -> None:
    """0.01 kg m a pendulum, three of them: a rotor of 9 kg is compensated up to e = 1/300 m."""
    machine = balanced(3)
    s = summary(machine, along="drum.eccentricity", range=[0.002, 0.006], points=2, only="compensating")
    (family,) = s["branches"]
    assert family["range"] == [0.002, pytest.approx(0.03 / 9, rel=1e-8)]
    assert "beyond, the unbalances cannot compensate each other" in family["ends"]


def test_the_speed_given_by_the_drive_is_a_parameter_too() -> None:
    """000, table 1: both compensating states over the speed; below the natural frequency they are not stable."""
    r = run(
        SpeedCurve(along="drive.speed", range=[150, 400], only="compensating", points=1),
        load_machine("sperling-rollers/table-1"),
    )
    s = r.wucht.summary
    assert [b["stable"] for b in s["branches"]] == [[[150, 400]]] * 2
    assert r.speed.values == pytest.approx(r.value.values, rel=1e-12)
    phases = sorted(np.degrees(x["state"]["r1.phase"]) for x in s["states"])
    assert phases == pytest.approx([138.59, 221.41], abs=0.005)


def test_speeds_of_no_rotor_are_left_out_with_a_sentence() -> None:
    s = summary(load_machine("drozdetskaya-2020/table-3.1-carrier"), along="u", range=[0.0, 0.5], points=1)
    (branch,) = s["branches"]
    assert "below 0.002 a rotor hardly turns, and the averaged equations do not hold" in branch["ends"]


def test_angles_that_differ_by_turns_are_one_branch() -> None:
    """theta' = mu - sin(theta) has one closed branch over mu."""
    theta, mu = sp.symbols("theta mu", real=True)
    own = UserSystem(System((theta,), (mu - sp.sin(theta),), (mu,), angles=frozenset({theta})), {"mu": 0.5})
    s = summary(own, along="mu", range=[-2.0, 2.0])
    (branch,) = s["branches"]
    assert branch["ends"] == ["it is closed"] * 2
    assert sorted(p["mu"] for p in s["special_points"]) == pytest.approx([-1, 1], abs=1e-10)
    assert sorted((x["state"]["theta"], x["stable"]) for x in s["states"]) == [
        (pytest.approx(math.pi / 6), True), (pytest.approx(5 * math.pi / 6), False),
    ]  # fmt: skip


def own_equations(rate: str, name: str = "mu", value: float = 0.5) -> UserSystem:
    """x' = rate, a formula in x and one parameter."""
    x, parameter = sp.symbols(f"x {name}", real=True)
    return UserSystem(System((x,), (sp.sympify(rate, {"x": x, name: parameter}),), (parameter,)), {name: value})


def test_a_branch_that_was_found_at_its_bifurcation_is_counted_once() -> None:
    """The middle one of five values from -1 to 1 is 0, where x' = mu x - x^3 branches."""
    s = summary(own_equations("mu*x - x**3"), along="mu", range=[-1.0, 1.0], ranges={"x": [-2, 2]})
    assert 0.0 in s["searched"]
    assert sorted((b["range"], b["stable"]) for b in s["branches"]) == [
        ([-1.0, 1.0], [[-1.0, 0.0]]), ([0.0, 1.0], [[0.0, 1.0]]),
    ]  # fmt: skip
    assert len(s["states"]) == 3 and [p["mu"] for p in s["special_points"]] == [0.0]


@pytest.mark.slow
def test_stability_ends_at_the_branch_point_and_not_at_a_point_beside_it_that_is_neutral() -> None:
    """R1: both pendulums just compensate the rotor of 8.75 kg at e = 2 * 0.125 * 0.104 / 9.75 m; together stable beyond."""
    s = summary(load_machine("drozdetskaya-2020/r1"), along="drum.eccentricity", range=["0 mm", "5 mm"])
    (point,) = [p["drum.eccentricity"] for p in s["special_points"] if p["kind"] == "branch-point"]
    assert point == pytest.approx(0.0026667, abs=1e-7)
    stable = [span for b in s["branches"] if b["name"] == "together" for span in b["stable"]]
    assert min(low for low, high in stable if high == 0.005 and low > 0.0025) == pytest.approx(point, abs=1e-9)
    # What is drawn at the ends of a stretch is in the order of the values: at the branch point nothing vibrates.
    speeds = [pair for b in s["branches"] for pair in b["stable_speeds"] if b["name"] == "together"]
    assert [first for first, last in speeds if last < first] == pytest.approx([200.0, 91.089], abs=1e-3)


@pytest.mark.slow
def test_the_centrifuge_has_a_stretch_on_which_only_some_members_compensate() -> None:
    asked = {"along": "drive.no_load_speed", "range": ["60 rad/s", "100 rad/s"], "points": 1, "only": "compensating"}
    r = run(SpeedCurve(**asked), load_machine("practice/laboratory-centrifuge"))
    s = r.wucht.summary
    (family,) = s["branches"]
    ((begins, some_end),), ((all_begin, ends),) = family["partly_stable"], family["stable"]
    assert 66 < begins < 67 and 75.5 < some_end == all_begin < 77 and ends == 100
    ((least, most),) = family["partly_stable_shares"]
    assert 0 < least < 0.01 and most == 1
    assert {p["kind"] for p in s["special_points"]} == {"some-stable", "all-stable"}
    assert "one family with members that are stable and others that are not" in s["sentence"]
    assert any("some members stable and others not from 66" in line for line in report(r))


@pytest.mark.parametrize("name", ["kind", "second_value"])
def test_a_parameter_may_have_the_name_of_a_key(name: str) -> None:
    """The fold of x' = p - x^2 is at p = 0, whatever p is called; the other meaning of the key stays."""
    r = run(SpeedCurve(along=name, range=[-1, 1], ranges={"x": [-2, 2]}), own_equations(f"{name} - x**2", name))
    (fold,) = r.wucht.summary["special_points"]
    assert fold["kind"] == "fold" and fold["value"] == fold["state"]["x"] == pytest.approx(0, abs=1e-6)
    assert fold["frequency"] is None
    assert (name in fold) == (name != "second_value")
    assert any(line.startswith(f"  fold         {name} = ") for line in report(r))


def test_a_continuum_of_equilibria_is_said_to_be_none_of_isolated_points() -> None:
    r = run(SpeedCurve(along="mu", range=[-1, 1], ranges={"x": [-2, 2]}), own_equations("mu*x*0"))
    (warning,) = [w for w in r.wucht.warnings if "could not be searched" in w]
    assert "at 7 values of mu from -0.998 to 0.998" in warning and "the equations are singular at every start" in warning


AB_18 = UserSystem(AB, {"p1": 0.1, "p2": 18.0}, "AUTO demo ab")
AB_RANGES = {"u1": [0, 1], "u2": [0, 10]}


def test_own_equations_and_the_plane_of_two_parameters() -> None:
    """AUTO-07p, demo ab: Hopf points and folds at p2 = 18. The cusp by hand: p2 = 16, p1 = exp(-2)."""
    r = run(SpeedCurve(along="p1", range=[0.0, 0.5], second="p2", second_range=[5.0, 20.0], ranges=AB_RANGES), AB_18)
    s = r.wucht.summary
    assert [(p["kind"], p["p1"]) for p in s["special_points"]] == [
        (kind, pytest.approx(value, rel=5e-8))
        for kind, value in
        (("hopf", 0.11115348), ("fold", 0.11156508), ("fold", 0.09957414), ("hopf", 0.18383461))
    ]  # fmt: skip
    kinds = {c["of"]: [p["kind"] for p in c["special_points"]] for c in s["curves"]}
    assert kinds == {"hopf": ["generalised-hopf"], "fold": ["cusp"]}
    (cusp,) = [p for c in s["curves"] for p in c["special_points"] if p["kind"] == "cusp"]
    assert (cusp["p1"], cusp["p2"]) == pytest.approx((math.exp(-2), 16.0), rel=1e-7)
    assert not {"speed", "amplitude", "own_speed", "special_speed", "curve_speed"} & set(r.variables)
    of_machines = {"speed", "amplitude", "stable_speeds", "partly_stable", "type", "name", "exponents_phi", "family_dimension"}
    for table in ("special_points", "states", "branches", "curves"):
        assert s[table] and not of_machines & s[table][0].keys()
    (branch,) = s["branches"]
    assert branch["stable_u1"][0][1] == pytest.approx(s["special_points"][0]["state"]["u1"], abs=1e-6)
    other = run(SpeedCurve(along="p1", range=[0.0, 0.5], ranges=AB_RANGES, show="u2", points=1), AB_18)
    assert draw(other).axes[0].get_ylabel() == "u2"
    assert [list(b)[1] for b in other.wucht.summary["branches"]] == ["stable_u2"]


@pytest.mark.parametrize(
    "asked",
    [
        {},
        {"ranges": {"u1": [0, 1]}},
        {"ranges": AB_RANGES | {"u3": [0, 1]}},
        {"ranges": AB_RANGES, "only": "together"},
        {"ranges": AB_RANGES, "show": "speed"},
        {"ranges": AB_RANGES, "along": "p3"},
    ],
)
def test_bad_questions_of_own_equations_are_refused(asked: dict[str, Any]) -> None:
    keys = {"along": "p1", "range": [0.0, 0.5]} | asked
    check_refusal(f"speed-curve of two equations: {asked}", lambda: summary(AB_18, **keys))


@pytest.mark.slow
def test_interrupted_and_resumed_it_is_the_same(tmp_path: Path) -> None:
    machine, spec = load_machine(TABLE), SpeedCurve(along="u", range=[0.5, 7.0], points=2)
    whole, looked = run(spec, machine), list[float]()

    def stop(share: float, _: str) -> None:
        looked.append(share)
        if share > 0.2 and not (tmp_path / "stopped").exists():
            (tmp_path / "stopped").touch()
            raise KeyboardInterrupt

    begun = run(spec, machine, folder=tmp_path / "r", progress=stop)
    assert not begun.attrs["finished"] and looked == sorted(looked)
    assert any("the search is not finished" in w for w in begun.wucht.warnings)
    resumed = run(spec, machine, folder=tmp_path / "r", resume=True, progress=stop)
    assert resumed.wucht.summary == whole.wucht.summary
    assert resumed.drop_attrs().identical(whole.drop_attrs())
