"""Bodies of one track: single collisions against momentum and restitution, and that nothing ever tunnels."""

import math

import numpy as np
import pytest
from tests.refusals import refused

from witness import energy_gap
from wucht import RunUp
from wucht.dynamics.run_ups.run_up import prepare_start
from wucht.files.building import machine_from
from wucht.machines.tracks import angular_width
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

TURN = 2 * math.pi
STILL = {"kind": "constant-speed", "speed": 0.0}
RING = {"kind": "rotor", "name": "ring", "mass": 2.0, "eccentricity": 0.0, "inertia": 0.02}


def ball(name, **more):
    """A point ball of 0.1 kg on a circle of 0.1 m, 20 mm thick: two that touch are 0.2003 rad apart."""
    return {
        "kind": "pendulum",
        "name": name,
        "about": "ring",
        "mass": 0.1,
        "length": 0.1,
        "diameter": 0.02,
        "track": "t",
    } | more


def moved(machine, start, grid):
    machine, initial = prepare_start(machine, start, float(grid[-1]))
    flow = compile_system(machine.system)
    run = integrate(flow, initial, machine.values, grid)
    assert run.failure is None
    rows = dict(zip(machine.system.state_names, run.states, strict=True)) | dict(run.quadratures)
    return machine, rows | flow.outputs(run.time, run.states, run.final_parameter_values)


def gaps(machine, rows):
    """Of every two neighbours in the order of the start, counter-clockwise: negative where they overlap. (n, N)"""
    (track,) = machine.tracks
    order = sorted(track.bodies, key=lambda b: rows[f"{b.name}.angle"][0] % TURN)
    apart = []
    for a, b in zip(order, [*order[1:], order[0]], strict=True):
        ahead = rows[f"{b.name}.angle"] - rows[f"{a.name}.angle"]
        first = ahead[0] % TURN
        apart.append(ahead - ahead[0] + first - angular_width(a, b))
    return np.array(apart)


@pytest.mark.parametrize(
    ("e1", "e2", "mass"), [(0.5, 0.5, 0.1), (0.05, 0.05, 0.1), (0.9, 0.4, 0.3), (1.0, 1.0, 0.02), (0.3, None, 0.2)]
)
def test_one_collision_on_a_free_ring(e1, e2, mass):
    """No damping, the ring held: the balls meet once within the time looked at. Their relative speed is turned round times the
    restitution (of two different ones the geometric mean), their angular momentum stays: both to 1e-9 at 4 against -1 rad/s."""
    other = ball("b", mass=mass, **({} if e2 is None else {"restitution": e2}))
    machine = machine_from(
        {"carrier": {"directions": "fixed"}, "bodies": [RING, ball("a", restitution=e1), other], "drive": STILL}
    )
    start = {"a": {"angle": 0.0, "speed": 4.0}, "b": {"angle": 1.2, "speed": -1.0}}
    _, rows = moved(machine, start, np.linspace(0, 0.5, 11))
    after_a, after_b = rows["a.speed"][-1], rows["b.speed"][-1]
    e = math.sqrt(e1 * (0.5 if e2 is None else e2))
    assert after_b - after_a == pytest.approx(5 * e, abs=1e-8)
    assert 0.1 * after_a + mass * after_b == pytest.approx(0.1 * 4 - mass, abs=1e-10)
    reduced = 0.1 * mass / (0.1 + mass) * 0.01
    assert rows["dissipated_work"][-1] == pytest.approx(reduced * 25 * (1 - e**2) / 2, abs=1e-11)
    assert energy_gap(rows) < 1e-9


def grinder(count, gravity=0.0, **track):
    """A grinder of 200 rad/s on a soft mounting at 80 rad/s with balls in oil, unbalanced by less than they can balance."""
    bodies = [
        {"kind": "rotor", "name": "ring", "mass": 2.0, "unbalance": 4e-3 * count / 2, "inertia": 0.02},
        *({"kind": "pendulum", "name": f"b{i}", "about": "ring", "mass": 0.03, "length": 0.1, "damping": 2e-3, "diameter": 0.02,
           "track": "t"} for i in range(count)),
    ]  # fmt: skip
    document = {
        "carrier": {"stiffness": 80.0**2 * 3, "damping": 60.0, "mass": 1.0, "gravity": gravity},
        "bodies": bodies,
        "drive": {"kind": "linear", "slope": 0.1, "no_load_speed": 200.0},
    }
    return machine_from(document | ({"tracks": {"t": track}} if track else {}))


def spread(count, first=0.1, apart=0.25):
    return {f"b{i}": first + apart * i for i in range(count)}


CASES = {
    "two under gravity": (2, spread(2, 0.1, 0.21), 9.81),
    "three, one shot against two": (3, {"b0": {"angle": 0.0, "speed": 90.0}, "b1": 1.0, "b2": 1.2005}, 0.0),
    "four symmetric, touching": (4, {"b0": 0.1001674212, "b1": 0.3005022636, "b2": -0.1001674212, "b3": -0.3005022636}, 0.0),
    "ten under gravity": (10, spread(10), 9.81),
}


@pytest.mark.parametrize("case", [pytest.param(c, marks=[pytest.mark.slow] if CASES[c][0] > 3 else []) for c in CASES])
def test_nothing_tunnels(case):
    """The deepest overlap is that of a spring of 20 times the operating speed: closing speed/(20 w), 0.05 rad where a ball at
    rest meets one at full speed, of 0.2 rad that two balls are apart. One that tunnelled would go on beyond -0.2 rad."""
    count, start, gravity = CASES[case]
    machine, rows = moved(grinder(count, gravity), start, np.linspace(0, 1.0, 4001))
    apart = gaps(machine, rows)
    assert apart.min() > -0.05
    assert apart.min() < 1e-6  # they met
    assert apart.sum(axis=0) == pytest.approx(apart[:, 0].sum(), abs=1e-9)  # and always the whole circle
    assert energy_gap(rows) < 1e-9
    assert (np.diff(rows["dissipated_work"]) > -1e-12).all()


def test_symmetric_starts_stay_symmetric():
    """Two balls that meet head on, mirrored at the line of a ring that is held: both corners of a collision at one instant."""
    bodies = [RING, *(ball(n, damping=1e-4) for n in "abcd")]
    document = {"carrier": {"directions": "fixed"}, "bodies": bodies, "drive": STILL}
    machine = machine_from(document | {"tracks": {"t": {"contact_frequency": 2000.0}}})
    start = {
        "a": {"angle": 0.5, "speed": -7.0}, "b": {"angle": -0.5, "speed": 7.0},
        "c": {"angle": 2.5, "speed": 5.0}, "d": {"angle": -2.5, "speed": -5.0},
    }  # fmt: skip
    machine, rows = moved(machine, start, np.linspace(0, 3, 601))
    assert rows["a.angle"] == pytest.approx(-rows["b.angle"], abs=1e-10)
    assert rows["c.angle"] == pytest.approx(-rows["d.angle"], abs=1e-10)
    assert gaps(machine, rows).min() > -14 / 2000
    assert energy_gap(rows) < 1e-9


@pytest.mark.parametrize(
    ("start", "refusal"),
    [
        ({"b0": 0.0, "b1": 0.19}, refused("study.start.b1", "b0")),
        ({"b0": 0.0, "b1": -0.19}, refused("study.start.b0", "b1", given=0.0)),
        ({"b0": "359 deg", "b1": "1 deg"}, refused("study.start.b1", given=1.0)),
    ],
)
def test_starts_that_overlap_are_refused(start, refusal):
    with refusal:
        RunUp(until=1.0, start=start).prepare(grinder(2))


@pytest.mark.parametrize(
    ("bodies", "refusal"),
    [
        ([ball(f"b{i}") for i in range(32)], refused("machine.bodies[1] (b0).track", "32", given="t")),
        ([ball("a", diameter=0.3), ball("b")], refused("machine.bodies[1] (a).diameter", given=0.3)),
        (
            [{k: v for k, v in ball("a").items() if k != "diameter"}, ball("b")],
            refused("machine.bodies[1] (a).diameter", given=None, code="missing"),
        ),
    ],
)
def test_tracks_that_cannot_be_are_refused(bodies, refusal):
    with refusal:
        machine_from({"carrier": {"directions": "fixed"}, "bodies": [RING, *bodies], "drive": STILL})


INVERTER = {
    "on": "ring", "kind": "inverter", "set_speed": "1200 rpm", "gain": 3.0, "integral_time": 0.5, "torque_limit": 15.0,
    "power_limit": 700.0,
}  # fmt: skip
MOTOR = {"on": "ring", "kind": "linear", "slope": 0.1, "no_load_speed": 150.0}
ON_SPRINGS = {"mass": 2.0, "stiffness": 2e4, "damping": 10.0}


@pytest.mark.parametrize(
    ("drives", "schedules", "fastest"),
    [
        ([INVERTER], [("drive.set_speed", [[0, 0], ["3 s", "-1500 rpm"], ["9 s", "600 rpm"]], "smooth")], 50 * math.pi),
        ([INVERTER], [("drive.set_speed", [["1 s", "0 rpm"], ["3 s", "2400 rpm"], ["4 s", "0 rpm"]], "steps")], 80 * math.pi),
        ([MOTOR, STILL | {"on": "other"}], [("drives.other.speed", [[0, 0], [5, -400]], "linear")], 400.0),
    ],
    ids=["both ways", "steps", "two drives"],
)
def test_contacts_are_fast_beside_the_fastest_operation_of_the_schedules(drives, schedules, fastest):
    """Twenty times it, not twenty times the operation at the start of a schedule, which may be standstill."""
    other = [{"kind": "rotor", "name": "other", "mass": 1.0, "eccentricity": 0.0, "inertia": 0.01}] if len(drives) > 1 else []
    machine = machine_from(
        {
            "carrier": ON_SPRINGS, "bodies": [RING, *other, ball("a"), ball("b")],
            **({"drive": drives[0]} if len(drives) == 1 else {"drives": drives}),
            "schedules": [{"parameter": p, "points": points, "interpolation": kind} for p, points, kind in schedules],
        }
    )  # fmt: skip
    assert machine.values["tracks.t.contact_frequency"] == pytest.approx(20 * fastest, rel=1e-6)
