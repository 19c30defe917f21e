"""The synchronising torque of exciters far above all resonances, where it has a closed form, and what happens beyond it.

I. I. Blekhman, Synchronization in Science and Technology (ASME Press, 1988): two equal exciters at a distance l on either side
of the centre of mass of a softly supported body, of mass M and moment of inertia J with the exciters on it, give each other the
vibration moment (m e w)^2/(2 M) (M l^2/J - 2) sin(delta) where they turn in one sense, and (m e w)^2 l^2/(2 J) sin(delta) where
they turn in opposite senses. It follows here from the forces of a free body alone: H = -diag(1/M, 1/M, 1/J)/w^2.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from wucht import DriveFailure, RunUp, SynchronousStates, load_machine, run, run_file
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.studies.study_file import read_study

UNBALANCE, ARM, SPEED, SLOPE, MASS, INERTIA = 0.4, 1.0, 150.0, 2.0, 400.0, 100.0
SOFT = 1.0  # rad/s: natural frequency, for which the forms of a free body are right to (SOFT/SPEED)^2
SAME, OPPOSITE = 1.0, -1.0
EXCITER = {"kind": "rotor", "mass": 20.0, "unbalance": UNBALANCE, "inertia": 0.03}


def soft_body(
    places: list[tuple[float, float]], speeds: list[float], damping_ratio: float = 0.1, **of_rotors: float
) -> Machine:
    """A body on soft springs with exciters whose motors have these no-load speeds. Mass and inertia include the exciters."""
    own = INERTIA - sum(EXCITER["mass"] * (x * x + y * y) for x, y in places)  # type: ignore[operator]
    carrier = {
        "directions": "xyr", "mass": MASS - 20.0 * len(places), "inertia": own, "frequency": SOFT,
        "damping_ratio": damping_ratio,
        "rotation_frequency": SOFT, "rotation_damping_ratio": damping_ratio,
    }  # fmt: skip
    names = [f"e{k}" for k in range(1, len(places) + 1)]
    bodies = [EXCITER | of_rotors | {"name": n, "position": [x, y]} for n, (x, y) in zip(names, places, strict=True)]
    motors = [{"on": n, "kind": "linear", "slope": SLOPE, "no_load_speed": w} for n, w in zip(names, speeds, strict=True)]
    return machine_from({"carrier": carrier, "bodies": bodies, "drives": motors})


def pair(sense: float, ahead: float) -> Machine:
    return soft_body([(ARM, 0.0), (-ARM, 0.0)], [SPEED + ahead, sense * (SPEED - ahead)])


def largest(sense: float, speed: float = SPEED) -> float:
    """Blekhman's vibration moment."""
    if sense == OPPOSITE:
        return (UNBALANCE * speed * ARM) ** 2 / (2 * INERTIA)
    return (UNBALANCE * speed) ** 2 / (2 * MASS) * abs(MASS * ARM**2 / INERTIA - 2)


def stable_state(machine: Machine) -> dict[str, Any]:
    states = run(SynchronousStates(full=False), machine).wucht.summary["states"]
    return next(s for s in states if s["stable_slow"])


@pytest.mark.parametrize("sense", [SAME, OPPOSITE])
def test_the_largest_torque_is_the_vibration_moment(sense: float) -> None:
    """The motors differ by 2 ahead: on the line of each, half of that times its slope has to pass."""
    ahead = 0.3 * largest(sense) / SLOPE
    state = stable_state(pair(sense, ahead))
    moment = largest(sense, abs(state["speed"]))
    assert state["synchronisation_available"] == pytest.approx(moment, rel=1e-4)
    assert state["synchronisation_used"] == pytest.approx(SLOPE * ahead, rel=1e-9)
    assert state["synchronisation_ratio"] == pytest.approx(moment / (SLOPE * ahead), rel=1e-4)
    assert state["synchronisation_ratio_within_tolerances"] is None  # of linear drives there is no slip


def test_equal_motors_have_no_margin_but_a_largest_torque() -> None:
    state = stable_state(pair(OPPOSITE, 0.0))
    assert (state["synchronisation_used"], state["synchronisation_ratio"]) == (0.0, None)
    assert state["synchronisation_available"] == pytest.approx(largest(OPPOSITE), rel=1e-3)


@pytest.mark.parametrize("sense", [SAME, OPPOSITE])
@pytest.mark.parametrize(("share", "outcome"), [(0.97, "synchronised"), (1.03, "not-synchronised")])
def test_motors_that_differ_by_more_fall_out_of_step(sense: float, share: float, outcome: str) -> None:
    """By the full equations, from phases in which they would run."""
    machine = pair(sense, share * largest(sense) / SLOPE)
    start = {"e1": {"speed": SPEED}, "e2": {"angle": math.pi / 2, "speed": sense * SPEED}}
    summary = run(RunUp(start=start, until=60.0), machine).wucht.summary
    assert summary["outcome"] == outcome
    assert summary["synchronisation"]["ratio"] == pytest.approx(1 / share, rel=5e-3)


@pytest.mark.slow
def test_of_three_rotors_the_margin_is_where_their_states_end() -> None:
    """The largest s with P_i = (m e w)^2/2 sum_k (2/M + r_i . r_k/J) sin(d_ik) + (r_i x r_k)/J cos(d_ik) = s D_i, d_ik the
    difference of the phases of i and k, by another optimiser."""
    places, ahead = [(1.2, 0.3), (-0.8, 0.5), (-0.4, -0.8)], np.array([0.5, -0.1, -0.4])
    state = stable_state(soft_body(places, [float(SPEED + a) for a in ahead], damping_ratio=1e-4))
    needed, r = -SLOPE * (ahead - ahead.mean()), np.array(places)
    size = (UNBALANCE * abs(state["speed"])) ** 2 / 2
    along, across = 2 / MASS + r @ r.T / INERTIA, (np.outer(r[:, 0], r[:, 1]) - np.outer(r[:, 1], r[:, 0])) / INERTIA

    def rest(x: np.ndarray) -> np.ndarray:
        phases = np.array([0.0, x[0], x[1]])
        apart = phases[:, None] - phases
        return np.asarray(size * (along * np.sin(apart) + across * np.cos(apart)).sum(axis=1) - x[2] * needed)[1:]

    begin = [state["phases"]["e2"], state["phases"]["e3"], 1.0]
    assert rest(np.array(begin)) == pytest.approx(0.0, abs=1e-3 * size * along.max())
    best = minimize(lambda x: -x[2], begin, constraints={"type": "eq", "fun": rest}, method="SLSQP", options={"ftol": 1e-12})
    assert best.success
    assert state["synchronisation_ratio"] == pytest.approx(best.x[2], rel=3e-4)
    assert state["synchronisation_available"] == pytest.approx(best.x[2] * np.abs(needed).max(), rel=3e-4)


def test_a_rotor_without_supply_needs_its_losses_and_half_of_the_difference() -> None:
    """The bearings of both rotors take as much: half of what the other motor gives passes to the dead rotor."""
    friction, until = 0.02, 20.0
    machine = soft_body([(ARM, 0.0), (-ARM, 0.0)], [SPEED, -SPEED], bearing_damping=friction)
    case = run(DriveFailure(until=until), machine).wucht.summary["cases"][0]
    assert (case["drive"], case["outcome"]) == ("e1", "synchronised")
    assert case["synchronisation_used"] == pytest.approx(abs(case["torques"]["e2"]) / 2, rel=3e-3)
    assert case["synchronisation_used"] == pytest.approx(friction * case["speed"], rel=0.01)
    assert case["synchronisation_available"] == pytest.approx(largest(OPPOSITE, case["speed"]), rel=1e-3)
    assert case["phases"]["e2"] == pytest.approx(math.pi + math.asin(1 / case["synchronisation_ratio"]), abs=0.002)


@pytest.mark.parametrize(("name", "is_synchronous"), [("practice/screen", True), ("practice/screen-unsynchronised", False)])
def test_screens_of_the_catalogue_run_as_their_margin_says(name: str, is_synchronous: bool) -> None:
    summary = run_file(name).wucht.summary
    assert (summary["outcome"] == "synchronised") is is_synchronous
    assert (summary["synchronisation"]["ratio"] > 1) is is_synchronous


@pytest.mark.slow
def test_it_is_half_the_width_of_the_band_of_entrainment() -> None:
    """Linear drives whose no-load speeds differ by d, at one mean, need the slope times d/2: where it cannot pass, the band
    ends.

    Along the band the common speed falls a little, which the margin, at one speed, leaves out.
    """
    study = read_study("sperling-vibration/self-synchronisation-soft", {"study.kind": "entrainment", "study.points": 5})
    machine = study.subject
    states = run(SynchronousStates(full=False), machine).wucht.summary["states"]
    state = max((s for s in states if s["stable_slow"]), key=lambda s: abs(s["speed"]))
    low, high = run(study.spec, machine).wucht.summary["existence_band"]
    widest = 2 * state["synchronisation_available"] / machine.values["drives.e1.slope"]
    assert [-low, high] == pytest.approx([widest, widest], rel=0.02)


def test_tolerances_of_the_slip_lower_the_margin() -> None:
    """Two equal motors on the straight part of their lines, each with a torque T: with slips of 0.8 and 1.2 times the rated one
    they give 1.2 T and 0.8 T, so that 0.2 T has to pass (IEC 60034-1: 20 per cent of the slip from 1 kW on)."""
    plate = {"power": 3000.0, "speed": 1450 * math.pi / 30, "voltage": 400.0, "frequency": 50.0, "breakdown_torque_ratio": 2.8}
    places, carrier = [(0.7, 0.0), (-0.7, 0.0)], {"directions": "xyr", "mass": 360.0, "inertia": 80.0, "frequency": 5.0}
    carrier |= {"damping_ratio": 0.05, "rotation_frequency": 5.0, "rotation_damping_ratio": 0.05}
    bodies = [EXCITER | {"name": f"e{k}", "position": list(p), "bearing_damping": 0.03} for k, p in enumerate(places, 1)]
    motors = [{"on": f"e{k}", "kind": "induction", "sense": s, "nameplate": plate} for k, s in ((1, 1), (2, -1))]
    machine = machine_from({"carrier": carrier, "bodies": bodies, "drives": motors})
    state = stable_state(machine)
    torque = 0.03 * abs(state["speed"])  # of the bearings
    share = state["synchronisation_available"] / (0.2 * torque)
    assert state["synchronisation_used"] == pytest.approx(0.0, abs=1e-3)
    assert state["synchronisation_ratio_within_tolerances"] == pytest.approx(share, rel=0.05)


def test_machines_without_several_driven_rotors_state_no_margin() -> None:
    states = run(SynchronousStates(full=False), load_machine("practice/grinder-2-balls")).wucht.summary["states"]
    assert "synchronisation_ratio" not in states[0]
