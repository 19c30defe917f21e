"""Motors on inverters: the set speed, the limits, nothing winds up; against a simulation and closed forms."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from witness import energy_gap, moved
from wucht import RunUp, TorqueBalance, run
from wucht.analysis.relative_equilibria import RelativeEquilibria
from wucht.files.building import machine_from
from wucht.machines.operation import free_speed

J, B, K, T_I, LIMIT, SET = 0.4, 0.01, 2.0, 0.3, 5.0, 120.0
DRIVE = {"kind": "inverter", "set_speed": SET, "gain": K, "integral_time": T_I, "torque_limit": LIMIT}
ROTOR = {"kind": "rotor", "name": "drum", "mass": 10.0, "eccentricity": 0.0, "inertia": J, "bearing_damping": B}
FIXED = {"carrier": {"directions": "fixed"}, "bodies": [ROTOR], "drive": DRIVE}


def simulated(end: float, back: bool, power: float = math.inf) -> tuple[np.ndarray, np.ndarray]:
    """Time and speed of the same loop by SciPy, with a clipped torque; back: with or without the way back from the limit."""

    def rates(_: float, y: np.ndarray) -> list[float]:
        asked = K * (SET - y[0]) + y[1]
        most = min(LIMIT, power / max(abs(y[0]), 1e-9))
        torque = min(max(asked, -most), most)
        return [(torque - B * y[0]) / J, (torque - y[1] if back else asked - y[1]) / T_I]

    time = np.linspace(0.0, end, 3001)
    return time, solve_ivp(rates, (0.0, end), [0.0, 0.0], "LSODA", time, rtol=1e-9, atol=1e-9, max_step=0.01).y[0]


def test_nothing_winds_up() -> None:
    """The same motion as an independent loop; its overshoot stays below (limit - load)/gain, that of a plain loop does not."""
    time, speed = simulated(20.0, back=True)
    rows = moved(FIXED, grid=time)
    assert rows["drum.speed"] == pytest.approx(speed, abs=2e-5)
    overshoot = rows["drum.speed"].max() - SET
    assert 0 < overshoot < (LIMIT - B * SET) / K
    assert simulated(20.0, back=False)[1].max() - SET > 5 * overshoot
    assert np.abs(rows["motor_torque"]).max() <= LIMIT * (1 + 1e-12)
    assert np.abs(rows["drive.integral"]).max() <= LIMIT * (1 + 1e-9)
    assert rows["motor_power"] == pytest.approx(rows["motor_torque"] * rows["drum.speed"], rel=1e-12)
    assert energy_gap(rows) < 1e-9


@pytest.mark.parametrize("sense", [1, -1])
def test_in_the_end_it_turns_with_the_set_speed_whatever_the_load(sense: int) -> None:
    document = FIXED | {"drive": DRIVE | {"set_speed": sense * SET}, "load": {"kind": "coulomb", "torque": 2.0}}
    rows = moved(document, grid=np.linspace(0.0, 60.0, 61))
    assert rows["drum.speed"][-1] == pytest.approx(sense * SET, rel=1e-9)
    assert rows["drive.integral"][-1] == pytest.approx(sense * (2.0 + B * SET), rel=1e-6)
    assert free_speed(machine_from(document), machine_from(document).rotor) == pytest.approx(sense * SET, rel=1e-9)


def test_the_power_limit() -> None:
    time, speed = simulated(25.0, back=True, power=300.0)
    rows = moved(FIXED | {"drive": DRIVE | {"power_limit": "300 W"}}, grid=time)
    assert rows["drum.speed"] == pytest.approx(speed, abs=2e-5)
    assert rows["motor_power"].max() == pytest.approx(300.0, rel=1e-9)
    assert (np.abs(rows["motor_torque"]) <= np.minimum(LIMIT, 300.0 / np.maximum(speed, 1e-9)) * (1 + 1e-6)).all()


MOUNTED = FIXED | {"carrier": {"mass": 30.0, "stiffness": 1e5, "damping": 200.0}}
UNBALANCED = MOUNTED | {"bodies": [ROTOR | {"eccentricity": 0.01}]}


def test_the_poles_of_steady_rotation_have_those_of_the_controller() -> None:
    """Of a balanced rotor: J s^2 + (K + B) s + K/T_i = 0, and those of the carrier in the turning frame."""
    found = RelativeEquilibria.of(machine_from(MOUNTED | {"bodies": [ROTOR | {"eccentricity": 1e-7}]}))
    names = found.system.state_names
    guess = np.zeros(len(names))
    guess[names.index("drum.speed")] = 119.0
    steady = found.find_near(guess)
    assert steady.speed == pytest.approx(SET, rel=1e-12)
    assert steady.state[names.index("drive.integral")] == pytest.approx(B * SET, rel=1e-9)
    own = np.roots([J, K + B, K / T_I])
    carrier = np.roots([40.0, 200.0, 1e5])
    expected = [*own, *(s + 1j * w for s in carrier for w in (SET, -SET))]
    away = np.abs(steady.eigenvalues[:, None] - np.array(expected))
    assert len(steady.eigenvalues) == len(expected)
    assert away.min(axis=0).max() < 1e-6


def test_a_torque_that_is_too_small_is_captured() -> None:
    """What the torque balance says, the run does; a larger one passes."""
    outcomes = {}
    for limit in (5.0, 12.0):
        machine = machine_from(UNBALANCED | {"drive": DRIVE | {"torque_limit": limit}})
        outcomes[limit] = run(RunUp(until=30.0), machine).wucht.summary
    assert (outcomes[5.0]["outcome"], outcomes[12.0]["outcome"]) == ("captured", "passed")
    assert outcomes[12.0]["final_speed"] == pytest.approx(SET, rel=1e-6)


def test_on_a_turning_carrier_it_sees_the_speed_between_rotor_and_stator() -> None:
    """J phi'' = T, I rho'' = -k rho - c rho' - T with T = K (s - phi' + rho') + x within its limit, by SciPy."""
    inertia, stiffness, damping = 0.9, 300.0, 2.0
    carrier = {
        "directions": "xyr", "mass": 30.0, "inertia": inertia, "stiffness": 1e5, "damping": 200.0,
        "rotation_stiffness": stiffness, "rotation_damping": damping,
    }  # fmt: skip
    document = FIXED | {"carrier": carrier, "bodies": [ROTOR | {"bearing_damping": 0.0}]}
    time = np.linspace(0.0, 12.0, 601)

    def rates(_: float, y: np.ndarray) -> list[float]:
        phi, rho, turned, x = y
        torque = float(np.clip(K * (SET - phi + rho) + x, -LIMIT, LIMIT))
        return [torque / J, -(stiffness * turned + damping * rho + torque) / inertia, rho, (torque - x) / T_I]

    start = {"drum": {"speed": SET - 10.0}}
    known = solve_ivp(rates, (0.0, 12.0), [SET - 10.0, 0.0, 0.0, 0.0], "LSODA", time, rtol=1e-10, atol=1e-10, max_step=0.01).y
    rows = moved(document | {"drive": DRIVE | {"stator": "carrier"}}, start, time)
    assert rows["drum.speed"] == pytest.approx(known[0], abs=2e-5)
    assert rows["carrier.r"] == pytest.approx(known[2], abs=2e-6)
    assert np.abs(known[2]).max() > 0.01
    assert energy_gap(rows) < 1e-8


def test_torque_balance_holds_the_set_speed_or_hangs_at_the_limit() -> None:
    """The torque at the set speed is what load and vibration take; a limit below the resonance's needs is a second point."""
    enough, tight, low = (
        run(TorqueBalance(), machine_from(UNBALANCED | {"drive": DRIVE | {"torque_limit": t}})).wucht.summary["working_points"]
        for t in (12.0, 5.0, 0.8)
    )
    (held,) = enough
    assert (held["speed"], held["stable"], held["slope"], held["no_load_speed"]) == (SET, True, None, SET)
    w, z = SET, 10.0 * 0.01 * SET**2 / abs(1e5 - 40.0 * SET**2 + 200j * SET)
    assert held["torque"] == pytest.approx(B * w + 200.0 * w * z**2, rel=1e-9)
    assert [p["stable"] for p in tight] == [True, False, True]
    assert tight[0]["torque"] == pytest.approx(5.0, rel=1e-9)
    assert 45 < tight[0]["speed"] < 50 < tight[1]["speed"] < tight[2]["speed"] == SET
    assert low[-1]["speed"] < 80.0 + 1e-6
    assert low[-1]["torque"] == pytest.approx(0.8, rel=1e-9)


def test_the_line_through_its_working_point_is_upright() -> None:
    motor = machine_from(FIXED).drives[0]
    assert motor.linearisation(SET) == (math.inf, SET) and motor.linearisation(10.0) == (0.0, math.inf)
    assert motor.no_load_path() == "drive.set_speed"
