"""Locks: a body that is locked to another moves as if it were rigidly connected, a released one as if it had never been locked.

The witness is another mechanism: the same masses rigidly connected, described by absolute positions (``tests/witness.py``).
"""

import math

import numpy as np
import pytest
import sympy as sp
from tests.refusals import refused

from witness import Mechanism, along
from wucht import RunUp, run
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_up import prepare_start
from wucht.files.building import machine_from
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

FAR = {"time": 1e6}
DRUM = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.02, "inertia": 0.02, "bearing_damping": 1e-3}
P1 = {"kind": "pendulum", "name": "p1", "about": "drum", "mass": 0.3, "length": 0.1, "inertia": 0.004, "damping": 0.02}
P2 = {"kind": "pendulum", "name": "p2", "about": "p1", "mass": 0.2, "length": 0.15, "damping": 0.03}
MACHINE = {
    "carrier": {"mass": 1.0, "stiffness": [4e3, 9e3], "damping": [6.0, 9.0], "gravity": 9.81},
    "bodies": [DRUM, P1, P2],
    "drive": {"kind": "linear", "slope": 0.05, "no_load_speed": 45.0},
}
START = {"drum": 0.4, "p1": 0.7, "p2": -1.1}
TIME_GRID = np.linspace(0.0, 1.0, 51)


def released(*when, **changed):
    """MACHINE with releases of p1 and p2 (None: free from the start)."""
    bodies = [DRUM, *(b if w is None else b | {"release": w} for b, w in zip((P1, P2), when, strict=True))]
    return machine_from(MACHINE | {"bodies": bodies} | changed)


def states(machine, start, grid=TIME_GRID, parameters=None, initial=None):
    flow = compile_system(machine.system)
    trajectory = integrate(
        flow, initial_state(machine, start) if initial is None else initial, parameters or machine.values, grid
    )
    assert trajectory.failure is None
    outputs = flow.outputs(trajectory.time, trajectory.states, trajectory.final_parameter_values)
    return dict(zip(machine.system.state_names, trajectory.states, strict=True)) | dict(trajectory.quadratures) | outputs


def connected(free_p1, free_p2, drive=True):
    """The same masses, with p1 and p2 rigidly connected to what they turn about unless they are free."""
    names = ["x", "y", "phi", *(["one"] if free_p1 else []), *(["two"] if free_p2 else [])]
    m = Mechanism(*names)
    q = dict(zip(names, m.q, strict=True))
    x, y, phi = q["x"], q["y"], q["phi"]
    angle_1 = q["one"] if free_p1 else phi + START["p1"]
    angle_2 = q["two"] if free_p2 else angle_1 + START["p2"]
    at, g = sp.Matrix([x, y]), 9.81
    m.mass(1.0, at, g)
    for mass, arm, angle, inertia in ((2.0, 0.02, phi, 0.02), (0.3, 0.1, angle_1, 0.004), (0.2, 0.15, angle_2, 0.2 * 0.15**2)):
        m.mass(mass, at + arm * along(angle), g)
        m.turning(inertia - mass * arm**2, angle)
    m.spring(4e3, x)
    m.spring(9e3, y)
    m.damper(6.0, x)
    m.damper(9.0, y)
    m.damper(1e-3, phi)
    m.damper(0.02, angle_1 - phi)
    m.damper(0.03, angle_2 - angle_1)
    if drive:
        m.force(0.05 * (45.0 - m.rate(phi)), phi)
    return m


def expected(free_p1, free_p2):
    m = connected(free_p1, free_p2)
    first = START["drum"] + START["p1"]
    begin = [0.0, -9.81 * 3.5 / 9e3, START["drum"], *([first] if free_p1 else []), *([first + START["p2"]] if free_p2 else [])]
    motion = m.motion(begin, np.zeros(len(begin)), TIME_GRID)
    names = [str(s) for s in (*m.q, *m.v)]
    return dict(zip(names, motion, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "second"), [(None, None), (FAR, None), (None, FAR), (FAR, FAR)], ids=["free", "first", "second", "chain"]
)
def test_a_locked_body_is_rigidly_connected(first, second):
    """All combinations in a chain of two; both integrations are right to some 1e-11 over ten turns."""
    motion, other = states(released(first, second), START), expected(first is None, second is None)
    for name, theirs in (("carrier.x", "x"), ("carrier.y", "y"), ("drum.angle", "phi"), ("drum.speed", "dphi")):
        assert motion[name] == pytest.approx(other[theirs], abs=1e-9 * np.abs(other[theirs]).max())
    angle_1 = other["one"] if "one" in other else other["phi"] + START["p1"]
    angle_2 = other["two"] if "two" in other else angle_1 + START["p2"]
    assert motion["p1.angle"] == pytest.approx(angle_1, abs=1e-8)
    assert motion["p2.angle"] == pytest.approx(angle_2, abs=1e-8)
    assert np.abs(motion["drum.speed"]).max() > 10  # it did something


def test_locks_do_no_work_and_locked_dampers_lose_none():
    motion = states(released(FAR, FAR), START)
    gap = motion["supplied_work"] - motion["dissipated_work"] - motion["stored_energy"] + motion["stored_energy"][0]
    assert np.abs(gap).max() < 1e-9 * motion["supplied_work"].max()
    stiff = states(released(FAR, FAR, bodies=[DRUM, P1 | {"release": FAR, "damping": 9.0}, P2 | {"release": FAR}]), START)
    assert stiff["dissipated_work"] == pytest.approx(motion["dissipated_work"], rel=1e-9, abs=1e-9)


@pytest.mark.slow
def test_after_its_release_a_body_is_free():
    """A run with releases at 0.5 s and 0.8 s is three runs one after the other: locked, half locked, free."""
    machine = released({"time": 0.8}, {"time": 0.5})
    machine, initial = prepare_start(machine, START)
    result = run(RunUp(until=2.0, start=START), machine)
    state, parts = initial, []
    for begin, end, locked in ((0.0, 0.5, (1, 1)), (0.5, 0.8, (1, 0)), (0.8, 2.0, (0, 0))):
        values = machine.values | dict(zip(("p1.locked", "p2.locked"), locked, strict=True))
        flow = compile_system(machine.system)
        part = integrate(flow, state, values, np.linspace(begin, end, 2))
        state = part.end_state
        parts.append(state)
    names = machine.system.state_names
    for body in ("drum", "p1", "p2"):
        assert float(result.angle.sel(body=body)[-1]) == pytest.approx(parts[-1][names.index(f"{body}.angle")], abs=1e-8)
        assert float(result.speed.sel(body=body)[-1]) == pytest.approx(parts[-1][names.index(f"{body}.speed")], abs=1e-7)
    relative = (result.angle.sel(body="p2") - result.angle.sel(body="p1")).values
    before = result.time.values < 0.5
    assert relative[before] == pytest.approx(START["p2"], abs=1e-11)
    assert np.abs(relative[~before] - START["p2"]).max() > 0.1
    assert result.attrs["failure"] == ""


@pytest.mark.slow
def test_released_at_a_speed():
    """p1 until the drum has reached 10 rad/s: until then the run is that of the locked machine."""
    machine = released({"speed": 10.0}, None)
    result = run(RunUp(until=1.2, start=START), machine)
    relative = (result.angle.sel(body="p1") - result.angle.sel(body="drum")).values
    speed = result.speed.sel(body="drum").values
    first = int(np.argmax(speed >= 10.0))
    assert relative[:first] == pytest.approx(START["p1"], abs=1e-11)
    assert np.abs(relative[first + 3 :] - START["p1"]).min() > 0
    assert np.abs(relative[first:] - START["p1"]).max() > 0.1
    locked = run(RunUp(until=1.2, start=START), released(FAR, None))
    assert speed[:first] == pytest.approx(locked.speed.sel(body="drum").values[:first], abs=1e-8)


@pytest.mark.parametrize("speed", [pytest.param(50.0, marks=pytest.mark.slow), -50.0])
def test_a_speed_of_release_that_is_reached_at_the_start(speed):
    """The drum turns with 50 rad/s from the beginning: a release at 40 rad/s is one at t = 0, one at 60 rad/s never comes."""
    drive = {"kind": "constant-speed", "speed": speed}
    start = {"p1": 0.7, "p2": -1.1}
    free = run(RunUp(until=0.5, start=start), released(None, None, drive=drive))
    for engine in (None, "radau"):
        early = run(RunUp(until=0.5, start=start, tolerance=1e-9, engine=engine), released({"speed": 40.0}, None, drive=drive))
        assert early.angle.values[..., -1] == pytest.approx(free.angle.values[..., -1], abs=1e-6)
        never = run(RunUp(until=0.5, start=start, tolerance=1e-9, engine=engine), released({"speed": 60.0}, None, drive=drive))
        assert (never.angle.sel(body="p1") - never.angle.sel(body="drum")).values == pytest.approx(0.7, abs=1e-10)


def test_a_speed_of_release_that_no_other_body_can_reach_is_refused():
    with refused("machine.bodies[0] (drum).release", given=None, code="out-of-reach"):
        machine_from(MACHINE | {"bodies": [DRUM | {"release": {"speed": 5.0}}, P1, P2]})


@pytest.mark.slow
def test_the_torque_on_a_drum_of_given_speed_carries_what_is_locked_to_it():
    """phi = 30 t with both pendulums locked: the torque is the reaction in the rigidly connected mechanism."""
    machine = released(FAR, FAR, drive={"kind": "constant-speed", "speed": 30.0, "angle": 0.4})
    motion = states(machine, {"p1": 0.7, "p2": -1.1})
    m = connected(False, False, drive=False)
    x, y, phi = m.q
    a, b = sp.symbols("a b", real=True)
    along_x, along_y, torque = m.residuals([a, b, sp.S.Zero])
    accelerations = sp.solve([along_x, along_y], [a, b], dict=True)[0]
    function = sp.lambdify((x, y, phi, *m.v), torque.xreplace(accelerations))
    given = (motion[n] for n in ("carrier.x", "carrier.y", "drum.angle", "carrier.vx", "carrier.vy"))
    needed = function(*given, np.full(len(TIME_GRID), 30.0))
    assert motion["motor_torque"] == pytest.approx(needed, abs=1e-9 * np.abs(needed).max())
    assert motion["drum.angle"] == pytest.approx(0.4 + 30 * TIME_GRID, abs=1e-11)
    gap = motion["supplied_work"] - motion["dissipated_work"] - motion["stored_energy"] + motion["stored_energy"][0]
    assert np.abs(gap).max() < 1e-9 * np.abs(motion["stored_energy"]).max()


def test_the_torque_on_a_drum_that_is_sped_up():
    """The prescribed speed rises from 0 to 30 rad/s within 1 s: the torque holds the locked pendulums' inertia as well."""
    ramp = {"parameter": "drive.speed", "points": [[0.0, 0.0], [1.0, 30.0]]}
    machine = machine_from(
        MACHINE
        | {
            "bodies": [DRUM | {"eccentricity": 0.0, "bearing_damping": 0.0}, P1 | {"release": FAR}, P2 | {"release": FAR}],
            "carrier": {"directions": "fixed"}, "drive": {"kind": "constant-speed", "speed": 0.0}, "schedules": [ramp],
        }
    )  # fmt: skip
    motion = states(machine, {"p1": 0.7, "p2": -1.1}, np.linspace(0, 2, 41))
    inertia = 0.02 + 0.004 + 0.2 * 0.15**2
    time = np.linspace(0, 2, 41)
    away = time != 1.0
    assert motion["motor_torque"][away] == pytest.approx(np.where(time < 1, 30 * inertia, 0.0)[away], abs=1e-11)
    assert motion["p2.angle"] == pytest.approx(np.where(time < 1, 15 * time**2, 30 * time - 15) - 0.4, abs=1e-11)


def test_a_locked_rotor_turns_with_a_carrier_that_turns():
    """On a carrier that turns about the normal the locked rotor is part of it: frequency sqrt(c/(Theta + J + m a^2))."""
    body = {"kind": "rotor", "name": "exciter", "mass": 2.0, "eccentricity": 0.0, "inertia": 0.05, "release": FAR}
    carrier = {"directions": "r", "inertia": 0.4, "rotation_stiffness": 90.0}
    machine = machine_from({"carrier": carrier, "bodies": [body | {"position": [0.3, 0.0]}]})
    motion = states(machine, {"carrier": {"r": 0.01}})
    frequency = math.sqrt(90.0 / (0.4 + 0.05 + 2.0 * 0.3**2))
    assert motion["carrier.r"] == pytest.approx(0.01 * np.cos(frequency * TIME_GRID), abs=1e-11)
    assert motion["exciter.angle"] == pytest.approx(motion["carrier.r"] - 0.01, abs=1e-11)


def test_a_locked_rotor_on_a_planar_carrier_that_starts_to_turn():
    body = {"kind": "rotor", "name": "exciter", "mass": 2.0, "eccentricity": 0.0, "inertia": 0.05, "release": FAR}
    carrier = {"directions": "xyr", "mass": 5.0, "inertia": 0.4, "stiffness": 100.0, "rotation_stiffness": 90.0}
    machine = machine_from({"carrier": carrier, "bodies": [body]})
    motion = states(machine, {"carrier": {"vr": 0.2}})
    frequency = math.sqrt(90.0 / (0.4 + 0.05))
    assert motion["carrier.r"] == pytest.approx(0.2 / frequency * np.sin(frequency * TIME_GRID), abs=1e-11)
    assert motion["exciter.angle"] == pytest.approx(motion["carrier.r"], abs=1e-11)
