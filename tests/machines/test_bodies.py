"""Bodies against masses at absolute positions, integrated independently (``tests/witness.py``), and against 001 (64)-(65)."""

import math

import numpy as np
import pytest
import sympy as sp
from tests.refusals import refused

from witness import GRID, Mechanism, along, close, energy_gap, moved
from wucht.files.building import machine_from
from wucht.mechanics.lagrange import acceleration

CARRIER = {"mass": 1.0, "stiffness": [4e3, 9e3], "damping": [6.0, 9.0], "gravity": 9.81}
DRUM = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.03}
DRIVE = {"kind": "linear", "on": "drum", "slope": 0.05, "no_load_speed": 45.0}
REST = -9.81 / 9e3  # of one kilogram


def on_springs(*names):
    """x, y and the drum's angle phi with its masses, springs, dampers and drive; then further coordinates."""
    m = Mechanism("x", "y", "phi", *names)
    x, y, phi = m.q[:3]
    at = sp.Matrix([x, y])
    m.mass(1.0, at, 9.81)
    m.mass(2.0, at + 0.01 * along(phi), 9.81)
    m.turning(0.03 - 2e-4, phi)
    for k, c, q in ((4e3, 6.0, x), (9e3, 9.0, y)):
        m.spring(k, q)
        m.damper(c, q)
    m.force(0.05 * (45.0 - m.rate(phi)), phi)
    return m, at, phi


@pytest.mark.slow
@pytest.mark.parametrize("inertia", [None, 0.004])
def test_a_pendulum_whose_pivot_turns_with_the_drum(inertia):
    pendulum = {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.3, "length": 0.1, "damping": 0.02}
    pendulum |= {"suspension": [0.05, -0.03]} | ({} if inertia is None else {"inertia": inertia})
    rows = moved({"carrier": CARRIER, "bodies": [DRUM, pendulum], "drive": DRIVE}, {"drum": 0.4, "p": 0.7})
    m, at, phi = on_springs("theta")
    theta = m.q[3]
    pivot = at + 0.05 * along(phi) - 0.03 * along(phi + sp.pi / 2)
    m.mass(0.3, pivot + 0.1 * along(theta), 9.81)
    m.turning((inertia or 0.003) - 0.003, theta)
    m.damper(0.02, theta - phi)
    other = m.motion([0.0, 3.3 * REST, 0.4, 1.1], np.zeros(4), GRID)
    names = ("carrier.x", "carrier.y", "drum.angle", "p.angle", "carrier.vx", "carrier.vy", "drum.speed", "p.speed")
    for name, theirs in zip(names, other, strict=True):
        assert close(rows[name], theirs), name
    assert energy_gap(rows) < 1e-10
    assert np.ptp(rows["p.angle"] - rows["drum.angle"]) > 0.5


@pytest.mark.slow
def test_a_slider_moves_as_its_mass_does():
    """A guide at 1 rad in the frame of a drum that is driven, on springs, under gravity."""
    slider = {"kind": "slider", "name": "s", "about": "drum", "mass": 0.4, "angle": 1.0, "radius": 0.08, "stiffness": 3e3}
    document = {"carrier": CARRIER, "bodies": [DRUM, slider | {"damping": 2.0}], "drive": DRIVE}
    rows = moved(document, {"drum": 0.4, "s": {"displacement": "2 mm", "velocity": 0.1}})
    m, at, phi = on_springs("s")
    s = m.q[3]
    m.mass(0.4, at + (0.08 + s) * along(phi + 1.0), 9.81)
    m.spring(3e3, s)
    m.damper(2.0, s)
    other = m.motion([0.0, 3.4 * REST, 0.4, 2e-3], [0, 0, 0, 0.1], GRID)
    for name, theirs in zip(("carrier.x", "carrier.y", "drum.angle", "s.displacement"), other, strict=False):
        assert close(rows[name], theirs), name
    assert energy_gap(rows) < 1e-10


def test_two_sliders_in_a_disc_are_001():
    """001 (64)-(65), residual zero as expressions: phi from the vertical is the angle here less pi/2, phi_2 = phi + pi."""
    disc = {"kind": "rotor", "name": "disc", "mass": 5.0, "eccentricity": 0.0, "inertia": 0.02}
    sliders = [
        {"kind": "slider", "name": f"s{i}", "about": "disc", "mass": 1.0, "radius": 0.1, "stiffness": 2500.0, "damping": 2.0,
         "angle": a} for i, a in ((1, 0.0), (2, "180 deg"))
    ]  # fmt: skip
    machine = machine_from({"carrier": {"directions": "fixed", "gravity": 9.81}, "bodies": [disc, *sliders]})
    numbers = {sp.Symbol(p, real=True): sp.nsimplify(v, rational=True) for p, v in machine.values.items()}
    numbers[sp.Symbol("s2.angle", real=True)] = sp.pi
    (phi_c, w), (x1, v1), (x2, v2) = (
        (c.position, c.velocity) for c in (machine.rotor.coordinate, *(s.coordinate for s in machine.sliders))
    )
    motion = machine.system.second_order
    a = [acceleration(c) for c in machine.coordinates]
    residuals = (motion.mass * sp.Matrix(a) - motion.forces).xreplace(numbers)
    phi = phi_c - sp.pi / 2
    m, g, big_r, c, b, j0 = 1, sp.Rational(981, 100), sp.Rational(1, 10), 2500, 2, sp.Rational(1, 50)
    disc_a, s1_a, s2_a = a
    x64 = [m * s + b * v + c * x - m * (big_r + x) * w**2 + m * g * sp.cos(f)
           for s, v, x, f in ((s1_a, v1, x1, phi), (s2_a, v2, x2, phi + sp.pi))]  # fmt: skip
    moment = (j0 + m * ((big_r + x1) ** 2 + (big_r + x2) ** 2)) * disc_a + 2 * m * ((big_r + x1) * v1 + (big_r + x2) * v2) * w
    x65 = moment - m * g * (x1 - x2) * sp.sin(phi)
    for residual, printed in zip(residuals, (x65, *x64), strict=True):
        assert sp.simplify(sp.expand_trig(sp.expand(residual - printed))) == 0


@pytest.mark.slow
def test_several_rotors_and_bodies_about_each():
    """Two rotors of opposite senses on one axis, each with a pendulum, and a third without a drive."""
    other_drum = {"kind": "rotor", "name": "back", "mass": 1.5, "eccentricity": 0.02, "inertia": 0.01, "bearing_damping": 3e-3}
    idle = {"kind": "rotor", "name": "idle", "mass": 0.5, "unbalance": 0.01, "inertia": 0.005, "bearing_damping": 1e-3}
    pendulums = [
        {"kind": "pendulum", "name": f"p{i}", "about": about, "mass": 0.2, "length": 0.1, "damping": 0.01}
        for i, about in ((1, "drum"), (2, "back"))
    ]
    drives = [DRIVE, {"kind": "linear", "on": "back", "slope": 0.03, "no_load_speed": -60.0}]
    document = {"carrier": CARRIER, "bodies": [DRUM, other_drum, idle, *pendulums], "drives": drives}
    start = {"drum": 0.4, "back": -0.3, "idle": {"speed": "-20 rad/s"}, "p1": 1.0, "p2": {"angle": 2.0, "speed": -10.0}}
    rows = moved(document, start)
    m, at, phi = on_springs("back", "idle", "p1", "p2")
    back, idle_a, p1, p2 = m.q[3:]
    for angle, mass, arm, inertia in (
        (back, 1.5, 0.02, 0.01),
        (idle_a, 0.5, 0.02, 0.005),
        (p1, 0.2, 0.1, 2e-3),
        (p2, 0.2, 0.1, 2e-3),
    ):
        m.mass(mass, at + arm * along(angle), 9.81)
        m.turning(inertia - mass * arm**2, angle)
    for damping, turned in ((3e-3, back), (1e-3, idle_a), (0.01, p1 - phi), (0.01, p2 - back)):
        m.damper(damping, turned)
    m.force(0.03 * (-60.0 - m.rate(back)), back)
    begin = [0.0, 5.4 * REST, 0.4, -0.3, 0.0, 1.4, 1.7]
    other = m.motion(begin, [0, 0, 0, 0, -20.0, 0, -10.0], GRID)
    names = ("carrier.x", "carrier.y", "drum.angle", "back.angle", "idle.angle", "p1.angle", "p2.angle")
    for name, theirs in zip(names, other, strict=False):
        assert close(rows[name], theirs), name
    assert rows["back.speed"][-1] < -20
    assert energy_gap(rows) < 1e-10


def test_a_roller_about_a_drum_that_turns_backwards():
    """Rolling without slip: spin (R phi_0' - (R - r) phi')/r, 000 (3)."""
    roller = {
        "kind": "roller",
        "name": "r",
        "about": "drum",
        "mass": 0.3,
        "track_radius": 0.12,
        "radius": 0.02,
        "damping": 0.01,
    }
    document = {"carrier": CARRIER, "bodies": [DRUM, roller], "drive": DRIVE | {"no_load_speed": -45.0}}
    rows = moved(document, {"drum": 0.4, "r": 0.7})
    m, at, phi = on_springs("p")
    m.forces = [sp.S.Zero] * 4
    p = m.q[3]
    m.mass(0.3, at + 0.1 * along(p), 9.81)
    m.turning(0.4 * 0.3 * 0.02**2, (0.12 * phi - 0.1 * p) / 0.02)
    m.damper(0.01, p - phi)
    m.force(0.05 * (-45.0 - m.rate(phi)), phi)
    other = m.motion([0.0, 3.3 * REST, 0.4, 1.1], np.zeros(4), GRID)
    for name, theirs in zip(("carrier.x", "carrier.y", "drum.angle", "r.angle"), other, strict=False):
        assert close(rows[name], theirs), name
    assert energy_gap(rows) < 1e-10


def test_a_suspension_of_zero_is_none():
    pendulum = {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.3, "length": 0.1, "damping": 0.02}
    start = {"drum": 0.4, "p": 0.7}
    without = moved({"carrier": CARRIER, "bodies": [DRUM, pendulum], "drive": DRIVE}, start)
    other = moved({"carrier": CARRIER, "bodies": [DRUM, pendulum | {"suspension": ["0 mm", "0 mm"]}], "drive": DRIVE}, start)
    assert without["p.angle"] == pytest.approx(other["p.angle"], abs=1e-9)


@pytest.mark.parametrize(
    ("bodies", "refusal"),
    [
        ([{"kind": "slider", "name": "s", "mass": 1.0, "radius": 0.1, "stiffness": 1.0}],
         refused("machine.bodies[1] (s).about", code="missing")),
        ([{"kind": "slider", "name": "s", "about": "drum", "mass": 1.0, "radius": 0.1, "stiffness": 0.0}],
         refused("machine.bodies[1] (s).stiffness", code="limits")),
        ([{"kind": "slider", "name": "s", "about": "drum", "mass": 1.0, "radius": 0.1, "stiffness": 1.0,
           "release": {"time": 1.0}}], refused("machine.bodies[1] (s).release", given={'time': 1.0})),
        ([{"kind": "slider", "name": "s", "about": "drum", "mass": 1.0, "radius": 0.1, "stiffness": 1.0},
          {"kind": "pendulum", "name": "p", "about": "s", "mass": 1.0, "length": 0.1}],
           refused("machine.bodies[2] (p).about", given="s")),
        ([{"kind": "pendulum", "name": "p", "about": "drum", "mass": 1.0, "length": 0.1, "suspension": [0.1, 0.0]},
          {"kind": "pendulum", "name": "q", "about": "p", "mass": 1.0, "length": 0.1}],
         refused("machine.bodies[2] (q).about", given="p")),
        ([{"kind": "pendulum", "name": "p", "about": "drum", "mass": 1.0, "length": 0.1, "release": {}}],
         refused("machine.bodies[1] (p).release", given={})),
        ([{"kind": "pendulum", "name": "p", "about": "drum", "mass": 1.0, "length": 0.1,
           "release": {"time": 1.0, "speed": 1.0}}],
            refused("machine.bodies[1] (p).release", given={'time': 1.0, 'speed': 1.0})),
        ([{"kind": "pendulum", "name": "p", "about": "drum", "mass": 1.0, "length": 0.1,
           "release": {"time": "3 kg"}}], refused("machine.bodies[1] (p).release.time", code="dimension")),
    ],
)  # fmt: skip
def test_bodies_that_cannot_be_are_refused(bodies, refusal):
    with refusal:
        machine_from({"carrier": CARRIER, "bodies": [DRUM, *bodies], "drive": DRIVE})


def test_a_pendulum_at_rest_hangs():
    """Under gravity, on a pivot off the axis of a drum that is held by a large moment of inertia: small swings of sqrt(g/l)."""
    drum = {"kind": "rotor", "name": "drum", "mass": 1.0, "eccentricity": 0.0, "inertia": 1e9}
    pendulum = {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.1, "length": 0.2, "suspension": [0.3, 0.4]}
    rows = moved({"carrier": {"directions": "fixed", "gravity": 9.81}, "bodies": [drum, pendulum]}, {"p": -math.pi / 2 + 1e-5})
    swing = 1e-5 * np.cos(math.sqrt(9.81 / 0.2) * GRID)
    assert rows["p.angle"] + math.pi / 2 == pytest.approx(swing, abs=1e-10)  # the drum gives way by that
