"""Which steady states are reached from rest: against integrations of our own, run-ups, and machines that cannot start."""

from __future__ import annotations

import copy
import math
import tomllib
from importlib import resources
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.dynamics.run_ups.test_operating_points import three_in_a_circle

from wucht import CoastDown, Response, RunUp, TorqueBalance, run
from wucht.dynamics.run_ups.operating_points import SteadyState
from wucht.dynamics.run_ups.settled_from_rest import FromRest, SettledFromRest
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

MASS, UNBALANCE, INERTIA, STIFFNESS, DAMPING, TOP = 10.0, 0.02, 0.05, 1e5, 120.0, 180.0
STUDIES = (TorqueBalance(), Response(), CoastDown(until=0.1))


def motor(slope: float) -> Machine:
    """A rotor on a carrier with its resonance at 100 rad/s, and a motor of a limited power."""
    rotor = {"kind": "rotor", "name": "r", "mass": MASS - 1.0, "unbalance": UNBALANCE, "inertia": INERTIA}
    return machine_from({
        "carrier": {"mass": 1.0, "directions": "x", "stiffness": STIFFNESS, "damping": DAMPING}, "bodies": [rotor],
        "drive": {"on": "r", "kind": "linear", "slope": slope, "no_load_speed": TOP},
    })  # fmt: skip


def own_final_speed(slope: float, until: float = 40.0) -> float:
    """The mean speed in the last tenth, integrated from rest."""

    def rates(_: float, s: np.ndarray) -> list[float]:
        x, v, angle, speed = s
        coupling = -UNBALANCE * math.sin(angle)
        force = UNBALANCE * speed**2 * math.cos(angle) - DAMPING * v - STIFFNESS * x
        torque, determinant = slope * (TOP - speed), MASS * INERTIA - coupling**2
        return [v, (INERTIA * force - coupling * torque) / determinant, speed, (MASS * torque - coupling * force) / determinant]

    at = (0.9 * until, until)
    own = solve_ivp(rates, (0, until), [0.0] * 4, "DOP853", at, rtol=1e-9, atol=1e-10)
    return float(np.diff(own.y[2])[0] / (at[1] - at[0]))


def stable(balance: Any) -> list[dict[str, Any]]:
    return [p for p in balance.wucht.summary["working_points"] if p["stable"]]


@pytest.mark.slow
@pytest.mark.parametrize("slope", [0.02, 0.03])
def test_the_working_point_that_an_own_integration_reaches(slope: float) -> None:
    """From a slope between these on, the drive gets through: below it there are a slow point, captured, and a fast one."""
    balance, final = run(TorqueBalance(), motor(slope)), own_final_speed(slope)
    points = stable(balance)
    assert len(points) == (2 if slope < 0.025 else 1)
    assert [p["reached_from_rest"] for p in points] == [True, False][: len(points)]
    assert points[0]["speed"] == pytest.approx(final, rel=5e-3)
    assert not any(p["reached_from_rest"] for p in balance.wucht.summary["working_points"] if not p["stable"])
    of_two = f"2 of them stable; from rest it reaches {points[0]['speed']:.5g} rad/s"
    assert balance.attrs["sentence"].endswith(of_two if len(points) == 2 else "reached from rest")
    (end,) = balance.wucht.summary["from_rest"]
    assert end["outcome"] == ("captured" if len(points) == 2 else "passed")
    assert end["speeds"]["r"] == pytest.approx(final, rel=1e-3)
    operation = run(Response(), motor(slope)).wucht.summary["operation"]
    assert [o["reached_from_rest"] for o in operation] == [True, False][: len(points)]
    coasting = run(CoastDown(until=0.1), motor(slope))
    assert coasting.wucht.summary["reached_from_rest"] is (len(points) == 1)
    warnings = [w for w in coasting.wucht.warnings if "not reached from rest: the rotor is captured" in w]
    assert len(warnings) == len(points) - 1


@pytest.mark.slow
def test_of_two_configurations_the_one_of_a_run_up() -> None:
    """Three exciters in a circle run in two orders; without a start each of the two is reached or not as in a run-up."""
    deck = machine_from(three_in_a_circle(1))
    points = stable(run(TorqueBalance(), deck))
    assert len(points) == 2
    final = run(RunUp(until=20.0), deck).wucht.summary
    distances = [
        max(abs(math.remainder(p["phases"][n] - final["rotor_phases"][n], 2 * math.pi)) for n in ("e2", "e3")) for p in points
    ]
    assert min(distances) < 0.05 and max(distances) > 1.0
    assert points[int(np.argmin(distances))]["reached_from_rest"] is True


def screen(**drives: Any) -> dict[str, Any]:
    table = (resources.files("wucht.machines") / "catalogue/practice/screen.toml").read_text(encoding="utf-8")
    return copy.deepcopy(tomllib.loads(table)["machine"]) | drives


@pytest.mark.slow
def test_an_exciter_without_a_motor_that_stays_at_rest() -> None:
    """Both turn with the motor of one where they do so already; from rest the other one stays."""
    alone = machine_from(screen(drives=screen()["drives"][:1]))
    final = run(RunUp(until=20.0), alone)
    assert final.attrs["outcome"] == "not-synchronised" and abs(final.wucht.summary["mean_speeds"]["e2"]) < 1e-3
    for machine, answer in ((alone, False), (machine_from(screen()), True)):
        for study in STUDIES:
            s = run(study, machine).wucht.summary
            entries = s.get("working_points") or s.get("operation") or s["configurations"]
            answers = [e["reached_from_rest"] for e in entries if e.get("stable", True)]
            assert answers == [answer], study.kind


def test_where_the_run_decides_nothing_that_is_said() -> None:
    """A schedule that switches the drive off again; without it the state is reached."""
    points = [[0.0, TOP], [10.0, TOP], [11.0, 0.0]]
    switched = {"schedules": [{"parameter": "drive.no_load_speed", "points": points}]}
    machine = motor(0.03)
    off = machine_from({
        "carrier": {"mass": 1.0, "directions": "x", "stiffness": STIFFNESS, "damping": DAMPING},
        "bodies": [{"kind": "rotor", "name": "r", "mass": MASS - 1.0, "unbalance": UNBALANCE, "inertia": INERTIA}],
        "drive": {"on": "r", "kind": "linear", "slope": 0.03, "no_load_speed": TOP},
    } | switched)  # fmt: skip
    coasting = run(CoastDown(until=0.1), off)
    assert coasting.wucht.summary["reached_from_rest"] is None
    (words,) = [w for w in coasting.wucht.warnings if "from rest" in w]
    what = "operating state at the start: whether it is reached from rest is not known"
    assert words == f"{what}: the schedules switch the drive off again"
    assert run(CoastDown(until=0.1), machine).wucht.summary["reached_from_rest"] is True


def ended(speed: float = 100.0, outcome: str | None = "passed", **other: Any) -> FromRest:
    return FromRest((SettledFromRest(outcome, "as by hand", {"r": speed}, **other),))


@pytest.mark.parametrize(("state", "answer"), [
    (SteadyState(100.9), True), (SteadyState(101.1), False), (SteadyState(99.1), True), (SteadyState(98.9), False),
    (SteadyState(100.0, {"q": 6.0}), True), (SteadyState(100.0, {"q": 0.1 + 0.62 - 2 * math.pi}), True),
    (SteadyState(100.0, {"q": 0.1 + 0.64}), False), (SteadyState(100.0, share=0.29), True),
    (SteadyState(100.0, share=0.31), False), (SteadyState(104.0, reach=0.05), True), (SteadyState(106.0, reach=0.05), False),
])  # fmt: skip
def test_a_state_is_reached_within_its_tolerances(state: SteadyState, answer: bool) -> None:
    """1 % of the speed, a tenth of a turn and of the unbalance."""
    assert ended(phases={"q": 0.1}, share=0.2).is_reached("r", [state]) == [answer]


def test_the_nearest_of_several_states_is_reached_and_those_alike() -> None:
    near, far, mirrored = SteadyState(100.0, share=0.2), SteadyState(100.5, share=0.2), SteadyState(100.0, share=0.2)
    assert ended(share=0.2).is_reached("r", [far, near, mirrored]) == [False, True, True]
    assert ended(outcome="captured-modulated").is_reached("r", [near]) == [False]
    for open_end in (ended(outcome=None), ended(outcome="unidentified"), ended(outcome="failed")):
        assert open_end.is_reached("r", [near]) == [None]
    both = FromRest((*ended(50.0).ends, *ended(outcome="unidentified").ends))
    assert both.is_reached("r", [SteadyState(50.0), SteadyState(80.0)]) == [True, None]
