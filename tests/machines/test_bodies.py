"""Bodies against masses at absolute positions, integrated independently (``tests/witness.py``), and against 001 (64)-(65)."""

import numpy as np
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


def test_a_slider_is_not_released():
    slider = {"kind": "slider", "name": "s", "about": "drum", "mass": 1.0, "radius": 0.1, "stiffness": 1.0}
    released = slider | {"release": {"time": 1.0}}
    with refused("machine.bodies[1] (s).release", given={"time": 1.0}):
        machine_from({"carrier": CARRIER, "bodies": [DRUM, released], "drive": DRIVE})
