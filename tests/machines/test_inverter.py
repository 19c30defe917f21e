"""Motors on inverters: the set speed, the limits, nothing winds up; against a simulation and closed forms."""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from tests.refusals import refused

from witness import energy_gap, moved, moved_by_scipy
from wucht import CoastDown, RunUp, TorqueBalance, run
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.relative_equilibria import RelativeEquilibria
from wucht.files.building import machine_from
from wucht.machines.operation import free_speed
from wucht.machines.parts import drives
from wucht.schema import validate_table

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


def test_behind_a_gear_it_controls_the_speed_of_the_motor() -> None:
    """As the same loop without a gear, with all as the body feels it: torques and gain, the inertia of the motor."""
    ratio, inertia = 2.5, 0.02
    reduced = DRIVE | {"set_speed": SET / ratio, "gain": K * ratio**2, "torque_limit": LIMIT * ratio}
    time = np.linspace(0.0, 20.0, 401)
    geared = moved(FIXED | {"drive": DRIVE | {"transmission": {"ratio": ratio, "inertia": inertia}}}, grid=time)
    plain = moved(FIXED | {"bodies": [ROTOR | {"inertia": J + inertia * ratio**2}], "drive": reduced}, grid=time)
    assert geared["drum.speed"] == pytest.approx(plain["drum.speed"], abs=1e-7)
    assert ratio * geared["drum.speed"][-1] == pytest.approx(SET, rel=1e-6)


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


def test_below_its_limit_it_is_a_linear_loop() -> None:
    """From 1 rad/s beside the set speed, by the matrix exponential of J w' = K e + x - B w, T_i x' = K e."""
    matrix = np.array([[-(K + B) / J, 1 / J], [-K / T_I, 0.0]])
    rest = np.array([SET, B * SET])
    start = np.array([SET - 1.0, 0.0])
    grid = np.linspace(0.0, 2.0, 21)
    expected = [rest + expm(matrix * t) @ (start - rest) for t in grid]
    rows = moved(FIXED, {"drum": {"speed": SET - 1.0}}, grid)
    actual = np.array([rows["drum.speed"], rows["drive.integral"]]).T
    assert actual == pytest.approx(np.array(expected), rel=1e-8)


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


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_set_speed_is_held_by_a_torque_that_suffices_there(share: float, sense: int) -> None:
    """Whatever it would have to be elsewhere: by hand, the bearing against the limit, either way round."""
    drive = DRIVE | {"set_speed": sense * SET, "torque_limit": share * B * SET}
    machine = machine_from(MOUNTED | {"drive": drive})
    (point,) = run(TorqueBalance(range=(-1.5 * SET, 1.5 * SET)), machine).wucht.summary["working_points"]
    assert point["speed"] == pytest.approx(sense * min(share, 1.0) * SET, rel=1e-9)
    assert point["torque"] == pytest.approx(sense * min(share, 1.0) * B * SET, rel=1e-9)


def test_without_load_it_is_one_working_point_without_torque() -> None:
    machine = machine_from(MOUNTED | {"bodies": [ROTOR | {"bearing_damping": 0.0}]})
    (point,) = run(TorqueBalance(), machine).wucht.summary["working_points"]
    assert (point["speed"], point["torque"], point["stable"]) == (SET, 0.0, True)


def test_a_set_speed_of_zero_is_held() -> None:
    machine = machine_from(MOUNTED | {"drive": DRIVE | {"set_speed": 0.0}})
    assert free_speed(machine, machine.rotor) == 0.0


def test_a_torque_that_is_too_small_is_captured() -> None:
    """What the torque balance says, the run does; a larger one passes."""
    outcomes = {}
    for limit in (5.0, 12.0):
        machine = machine_from(UNBALANCED | {"drive": DRIVE | {"torque_limit": limit}})
        outcomes[limit] = run(RunUp(until=30.0), machine).wucht.summary
    assert (outcomes[5.0]["outcome"], outcomes[12.0]["outcome"]) == ("captured", "passed")
    assert outcomes[12.0]["final_speed"] == pytest.approx(SET, rel=1e-6)


@pytest.mark.slow
def test_it_runs_as_an_independent_integration_says() -> None:
    document, grid = UNBALANCED | {"drive": DRIVE | {"power_limit": 300.0}}, np.linspace(0.0, 8.0, 201)
    speed = moved_by_scipy(machine_from(document), grid=grid, max_step=1e-3)["drum.speed"]
    assert moved(document, grid=grid)["drum.speed"] == pytest.approx(speed, rel=1e-7, abs=1e-7)


def test_a_ramp_of_the_set_speed_is_followed() -> None:
    """With T_i J/K of the acceleration behind: what the integral has to bear for it."""
    ramp = {"parameter": "drive.set_speed", "points": [[0.0, 0.0], [40.0, SET]]}
    rows = moved(FIXED | {"schedules": [ramp], "bodies": [ROTOR | {"bearing_damping": 0.0}]}, grid=np.linspace(0.0, 60.0, 61))
    # x = J a in the steady ramp, and T_i x' = K e = 0: no lag is left.
    assert rows["drum.speed"][30] == pytest.approx(30.0 * SET / 40.0, rel=1e-9)
    assert rows["motor_torque"][30] == pytest.approx(J * SET / 40.0, rel=1e-9)


def test_the_line_through_its_working_point_is_upright() -> None:
    made = validate_table(
        drives()["inverter"], {"on": "drum"} | {k: v for k, v in DRIVE.items() if k != "kind"}, "machine.drive"
    )
    assert made.linearisation(SET) == (math.inf, SET)
    assert made.linearisation(10.0) == (0.0, math.inf)
    assert [made.torque_at(w) for w in (0.0, 119.0, SET, 121.0, -50.0)] == [LIMIT, LIMIT, 0.0, -LIMIT, LIMIT]
    assert made.no_load_path() == "drive.set_speed"
    weakened = made.model_copy(update={"power_limit": 300.0})
    assert [weakened.torque_at(w) for w in (0.0, 60.0, 100.0, 150.0)] == pytest.approx([5.0, 5.0, 3.0, -2.0], rel=1e-12)
    w = sp.Symbol("w", real=True)
    assert {s.name for s in made.torque(w).free_symbols - {w}} == {"drive.set_speed", "drive.torque_limit"}


def test_averaged_equations_have_no_place_for_it() -> None:
    with refused("machine", "drive.integral", code="controller"):
        averaged_equations_of(machine_from(UNBALANCED))


def test_it_coasts_down_without_its_controller() -> None:
    machine = machine_from(MOUNTED)
    half = run(CoastDown(until=60.0), machine).wucht.summary["half_time"]
    assert half == pytest.approx(J / B * math.log(2), rel=1e-3)


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


def test_the_torque_is_a_vertical_line_at_the_speed_that_the_gear_gives_to_the_body() -> None:
    """120 rad/s of the motor; half of that behind a gear of 2."""
    for transmission, held in ((None, SET), ({"ratio": 2.0}, SET / 2)):
        motor = machine_from(FIXED | {"drive": DRIVE | ({"transmission": transmission} if transmission else {})}).drives[0]
        assert motor.held_speed() == held and motor.linearisation(held) == (math.inf, held)
        assert motor.linearisation(0.9 * held)[0] != math.inf
