"""Carriers against matrices and equations of motion written by hand, and against masses at absolute positions."""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from tests.refusals import refused

from witness import GRID, Mechanism, along, close, energy_gap, moved
from wucht.analysis.vibration import Vibration
from wucht.files.building import machine_from

ROTOR = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.02}
DRIVE = {"kind": "linear", "on": "drum", "slope": 0.05, "no_load_speed": 60.0}
PLACES = {"left": (-0.3, 0.1), "right": (0.4, -0.05)}
MOUNTS = [
    {"at": [-0.5, -0.2], "stiffness": [2e3, 5e3], "damping": [3.0, 7.0]},
    {"at": [0.5, -0.3], "stiffness": [1e3, 8e3], "damping": [2.0, 4.0]},
    {"at": [0.1, 0.2], "stiffness": [0.0, 500.0]},
]
SCREEN = {
    "carrier": {"directions": "xyr", "mass": 30.0, "inertia": 3.0, "mounts": MOUNTS, "gravity": 9.81},
    "bodies": [
        {"kind": "rotor", "name": "left", "mass": 2.0, "eccentricity": 0.02, "inertia": 0.01, "position": list(PLACES["left"]),
         "bearing_damping": 2e-3},
        {"kind": "rotor", "name": "right", "mass": 3.0, "unbalance": 0.05, "inertia": 0.02, "position": list(PLACES["right"])},
    ],
    "drives": [
        {"kind": "linear", "on": "left", "slope": 0.05, "no_load_speed": 80.0},
        {"kind": "linear", "on": "right", "slope": 0.04, "no_load_speed": -90.0},
    ],
}  # fmt: skip


def matrices(machine):
    c, numbers = machine.linear_carrier, machine.numbers
    return tuple(np.array(a.xreplace(numbers).tolist(), float) for a in (c.mass, c.damping, c.stiffness))


def test_the_screens_matrices():
    """M, C, K by hand: a place (a, b) has the Jacobian [[1, 0, -b], [0, 1, a]]."""
    machine = machine_from(SCREEN)
    mass, damping, stiffness = matrices(machine)

    def at(place):
        a, b = place
        return np.array([[1, 0, -b], [0, 1, a]])

    by_hand = np.diag([30.0, 30.0, 3.0])
    for place, m in zip(PLACES.values(), (2.0, 3.0), strict=True):
        by_hand += m * at(place).T @ at(place)
    assert mass == pytest.approx(by_hand, rel=1e-14)
    for key, matrix in (("stiffness", stiffness), ("damping", damping)):
        parts = [at(m["at"]).T @ np.diag(m.get(key, [0, 0])) @ at(m["at"]) for m in MOUNTS]
        bearing = np.diag([0, 0, 2e-3 if key == "damping" else 0.0])  # the left rotor's bearing turns with the carrier
        assert matrix == pytest.approx(sum(parts) + bearing, rel=1e-12, abs=1e-12)


def test_the_screens_excitation():
    """proven.md: e_i = (1, -i s, -b - i s a) for a rotor at (a, b) of sense s; left turns forwards, right backwards."""
    excitation = Vibration.of(machine_from(SCREEN)).excitation
    for row, (a, b), u, s in zip(excitation, PLACES.values(), (0.04, 0.05), (1, -1), strict=True):
        assert row == pytest.approx(u * np.array([1, -1j * s, -b - 1j * s * a]), abs=1e-15)


def test_static_position_by_hand_and_that_it_rests():
    machine = machine_from(SCREEN)
    _, _, stiffness = matrices(machine)
    load = -9.81 * np.array([0.0, 35.0, 2.0 * -0.3 + 3.0 * 0.4])
    assert machine.rest == pytest.approx(np.linalg.solve(stiffness, load), rel=1e-12)
    balanced = [b | {"eccentricity": 0.0} for b in SCREEN["bodies"]]
    balanced[1].pop("unbalance")
    rows = moved({"carrier": SCREEN["carrier"], "bodies": balanced})
    for d in "xyr":  # by less than a step may be off: 1e-12 of 0.01 m and of the position
        position = rows[f"carrier.{d}"]
        assert np.ptp(position) < 1e-12 * (0.01 + np.abs(position).max())


def test_a_foundation_under_one_direction():
    """M q'' + c (q - z) + b (q - z)' = excitation - M g, m_f z'' + c_f z + b_f z' = c (q - z) + b (q - z)' - m_f g; z in y."""
    foundation = {"direction": "y", "mass": 40.0, "stiffness": 3e4, "damping": 50.0}
    carrier = {"mass": 3.0, "stiffness": [4e3, 6e3], "damping": [20.0, 30.0], "gravity": 9.81, "foundation": foundation}
    rows = moved({"carrier": carrier, "bodies": [ROTOR], "drive": DRIVE}, {"drum": 0.3, "carrier": {"x": 2e-3}})
    m = Mechanism("x", "y", "z", "phi")
    x, y, z, phi = m.q
    m.mass(3.0, sp.Matrix([x, y]), 9.81)
    m.mass(2.0, sp.Matrix([x, y]) + 0.01 * along(phi), 9.81)
    m.mass(40.0, sp.Matrix([z]), 9.81)
    m.turning(0.02 - 2e-4, phi)
    for k, c, stretch in ((4e3, 20.0, x), (6e3, 30.0, y - z), (3e4, 50.0, z)):
        m.spring(k, stretch)
        m.damper(c, stretch)
    m.force(0.05 * (60 - m.rate(phi)), phi)
    z0 = -45.0 * 9.81 / 3e4
    other = m.motion([2e-3, z0 - 5.0 * 9.81 / 6e3, z0, 0.3], np.zeros(4), GRID)
    for name, theirs in zip(("carrier.x", "carrier.y", "foundation.y", "drum.angle"), other, strict=False):
        assert close(rows[name], theirs), name
    assert energy_gap(rows) < 1e-10


def test_a_harmonic_motion():
    """001 (12)-(13): J phi'' = L + m e x'' sin phi with x = x_0 cos(Omega t); the force is what masses and springs take."""
    motion = {"direction": "x", "amplitude": "5 mm", "frequency": 31.0}
    document = {
        "carrier": {"directions": "x", "mass": 3.0, "stiffness": 4e3, "motion": motion},
        "bodies": [ROTOR],
        "drive": DRIVE,
    }
    rows = moved(document)
    assert rows["carrier.x"] == pytest.approx(5e-3 * np.cos(31 * GRID), abs=1e-14)

    def rates(t, s):
        return [s[1], (0.05 * (60 - s[1]) - 0.02 * 5e-3 * 31**2 * math.cos(31 * t) * math.sin(s[0])) / 0.02]

    other = solve_ivp(rates, (0, 1), [0, 0], "DOP853", GRID, rtol=1e-13, atol=1e-15).y
    assert close(rows["drum.angle"], other[0])
    assert close(rows["drum.speed"], other[1])
    assert energy_gap(rows) < 1e-10


def test_a_motion_through_points():
    """A cubic spline through measured points, its acceleration on the rotor; the points begin before the run."""
    times = np.array([-0.2, 0.0, 0.15, 0.4, 0.55, 0.8, 1.3])
    points = np.array([0.0, 2e-3, -3e-3, 1e-3, 4e-3, -2e-3, 0.0])
    motion = {"direction": "x", "points": np.column_stack([times, points]).tolist()}
    document = {"carrier": {"directions": "x", "stiffness": 0.0, "motion": motion}, "bodies": [ROTOR], "drive": DRIVE}
    rows = moved(document)
    spline = CubicSpline(times, points, bc_type="clamped")
    assert rows["carrier.x"] == pytest.approx(spline(GRID), abs=1e-14)
    bend = spline.derivative(2)

    def rates(t, s):
        return [s[1], (0.05 * (60 - s[1]) + 0.02 * bend(t) * math.sin(s[0])) / 0.02]

    # SciPy steps across the kinks of the acceleration: so it goes from point to point.
    state, pieces = np.zeros(2), []
    for begin, end in zip([0.0, *times[2:-1]], [*times[2:-1], 1.0], strict=True):
        piece = GRID[(begin <= GRID) & (end > GRID)]
        run = solve_ivp(rates, (begin, end), state, "DOP853", rtol=1e-13, atol=1e-15, dense_output=True)
        pieces.append(run.sol(piece))
        state = run.y[:, -1]
    other = np.concatenate(pieces, axis=1)
    assert close(rows["drum.angle"][:-1], other[0])
    assert energy_gap(rows) < 1e-9


def test_couple_unbalance():
    """001 (10)-(11) for two rotors: J phi'' = L + D chi'' sin phi, Theta chi'' = l + sum D (phi'^2 cos phi + phi'' sin phi)."""
    bodies = [
        {"kind": "rotor", "name": n, "mass": 2.0, "inertia": j, "couple_unbalance": d}
        for n, j, d in (("one", 0.02, 0.004), ("two", 0.03, 0.006))
    ]
    drives = [{"kind": "linear", "on": n, "slope": 0.05, "no_load_speed": w} for n, w in (("one", 60.0), ("two", -70.0))]
    carrier = {"directions": "r", "inertia": 0.5, "rotation_stiffness": 900.0, "rotation_damping": 0.6}
    rows = moved({"carrier": carrier, "bodies": bodies, "drives": drives}, {"two": 1.0, "carrier": {"r": 0.01}})
    j, d, free = np.array([0.02, 0.03]), np.array([0.004, 0.006]), np.array([60.0, -70.0])

    def rates(_t, s):
        chi, phi, v, w = s[0], s[1:3], s[3], s[4:]
        matrix = np.diag([0.5, *j])
        matrix[0, 1:] = matrix[1:, 0] = -d * np.sin(phi)
        right = [-900 * chi - 0.6 * v + (d * w**2 * np.cos(phi)).sum(), *(0.05 * (free - w))]
        return [v, *w, *np.linalg.solve(matrix, right)]

    other = solve_ivp(rates, (0, 1), [0.01, 0, 1.0, 0, 0, 0], "DOP853", GRID, rtol=1e-13, atol=1e-15).y
    for name, theirs in zip(("carrier.r", "one.angle", "two.angle", "carrier.vr"), other, strict=False):
        assert close(rows[name], theirs), name
    assert energy_gap(rows) < 1e-10


@pytest.mark.parametrize(
    ("carrier", "body", "refusal"),
    [
        (
            {"directions": "xyr", "mass": 1.0, "inertia": 1.0, "mounts": [MOUNTS[2] | {"stiffness": [-1.0, 1.0]}]},
            {},
            refused("machine.carrier.mounts", code="limits"),
        ),
        (
            {"stiffness": 1.0},
            {"position": [0.1, 0.0]},
            refused("machine.bodies[0] (drum).position", "xyr", "xy", given=[0.1, 0.0]),
        ),
        (
            {"stiffness": 1.0},
            {"eccentricity": None, "couple_unbalance": 0.1},
            refused("machine.bodies[0] (drum).couple_unbalance", "xy", given=0.1),
        ),
        (
            {"directions": "x", "stiffness": 1.0, "motion": {"direction": "y", "amplitude": 1.0, "frequency": 1.0}},
            {},
            refused("machine.carrier.motion", "x", code="direction"),
        ),
    ],
)
def test_carriers_that_cannot_be_are_refused(carrier, body, refusal):
    rotor = {k: v for k, v in (ROTOR | body).items() if v is not None}
    with refusal:
        machine_from({"carrier": carrier, "bodies": [rotor], "drive": DRIVE})


def test_gravity_beyond_that_of_any_centrifuge_is_refused():
    """Bodies would swing millions of times a second, and each swing be computed and stored."""
    for gravity, fits in (("1e7 m/s^2", True), ("1e12 m/s^2", False), (-1e8, False)):
        described = {
            "carrier": {"directions": "xy", "stiffness": 1e3, "gravity": gravity},
            "bodies": [ROTOR],
            "drives": [DRIVE],
        }
        if fits:
            assert machine_from(described).values["carrier.gravity"] == 1e7
        else:
            with refused("machine.carrier.gravity", "-1e+07", "1e+07 m/s^2", code="limits"):
                machine_from(described)
