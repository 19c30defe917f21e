"""Carriers against matrices and equations of motion written by hand, and against masses at absolute positions."""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from tests.refusals import refused

from witness import GRID, TIME, Mechanism, along, close, energy_gap, moved
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


def screen_by_hand(stator=False):
    """Masses at absolute positions: a place (a, b) of the carrier at (x - b chi, y + a chi), the rotors' centres off theirs."""
    m = Mechanism("x", "y", "chi", "left", "right")
    x, y, chi, *angles = m.q
    m.mass(30.0, sp.Matrix([x, y]), 9.81)
    m.turning(3.0, chi)
    for mount in MOUNTS:
        a, b = mount["at"]
        for k, c, stretch in zip(mount["stiffness"], mount.get("damping", (0, 0)), (x - b * chi, y + a * chi), strict=True):
            m.spring(k, stretch)
            m.damper(c, stretch)
    for angle, (a, b), mass, arm, inertia in zip(
        angles, PLACES.values(), (2.0, 3.0), (0.02, 0.05 / 3), (0.01, 0.02), strict=True
    ):
        m.mass(mass, sp.Matrix([x - b * chi, y + a * chi]) + arm * along(angle), 9.81)
        m.turning(inertia - mass * arm**2, angle)
    m.damper(2e-3, angles[0] - chi)
    for angle, slope, speed in zip(angles, (0.05, 0.04), (80.0, -90.0), strict=True):
        turned = angle - chi if stator else angle
        m.force(slope * (speed - m.rate(turned)), turned)
    return m


@pytest.mark.slow
@pytest.mark.parametrize("stator", ["foundation", "carrier"])
def test_a_screen_moves_as_its_masses_do(stator):
    """Full equations, gravity, two senses of rotation; with the stators on the carrier it feels the motors' reaction."""
    document = SCREEN | {"drives": [d | {"stator": stator} for d in SCREEN["drives"]]}
    rows = moved(document, {"left": 0.5, "right": -1.0, "carrier": {"x": 1e-3, "vr": 0.1}})
    rest = machine_from(document).rest
    begin = [rest[0] + 1e-3, rest[1], rest[2], 0.5, -1.0]
    other = screen_by_hand(stator == "carrier").motion(begin, [0, 0, 0.1, 0, 0], GRID)
    names = ("carrier.x", "carrier.y", "carrier.r", "left.angle", "right.angle")
    speeds = ("carrier.vx", "carrier.vy", "carrier.vr", "left.speed", "right.speed")
    for name, theirs in zip((*names, *speeds), other, strict=True):
        assert close(rows[name], theirs), name
    assert energy_gap(rows) < 1e-10


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


def test_springs_at_the_centre_are_those_of_a_planar_carrier():
    carrier = {"directions": "xyr", "mass": 30.0, "inertia": 3.0, "stiffness": [2e3, 5e3], "damping": 4.0}
    carrier |= {"rotation_stiffness": 700.0, "rotation_damping": 0.5}
    _, damping, stiffness = matrices(machine_from(SCREEN | {"carrier": carrier}))
    assert stiffness == pytest.approx(np.diag([2e3, 5e3, 700.0]))
    assert damping == pytest.approx(np.diag([4.0, 4.0, 0.5 + 2e-3]))  # and a bearing


def test_one_direction():
    """001 (8)-(9) with linear f and L, as printed (errata: x-double-dot)."""
    document = {
        "carrier": {"directions": "x", "mass": 3.0, "stiffness": 4e3, "damping": 20.0},
        "bodies": [ROTOR],
        "drive": DRIVE,
    }
    rows = moved(document, {"drum": 0.3, "carrier": {"x": 2e-3}})
    total, u, j = 5.0, 0.02, 0.02

    def rates(_t, s):
        x, phi, vx, w = s
        matrix = [[total, -u * math.sin(phi)], [-u * math.sin(phi), j]]
        right = [-20 * vx - 4e3 * x + u * w**2 * math.cos(phi), 0.05 * (60 - w)]
        return [vx, w, *np.linalg.solve(matrix, right)]

    other = solve_ivp(rates, (0, 1), [2e-3, 0.3, 0, 0], "DOP853", GRID, rtol=1e-13, atol=1e-15).y
    for name, theirs in zip(("carrier.x", "drum.angle", "carrier.vx", "drum.speed"), other, strict=True):
        assert close(rows[name], theirs)


@pytest.mark.parametrize("direction", [pytest.param("x", marks=pytest.mark.slow), "y"])
def test_a_foundation_under_one_direction(direction):
    """M q'' + c (q - z) + b (q - z)' = excitation - M g, m_f z'' + c_f z + b_f z' = c (q - z) + b (q - z)' - m_f g."""
    foundation = {"direction": direction, "mass": 40.0, "stiffness": 3e4, "damping": 50.0}
    carrier = {"mass": 3.0, "stiffness": [4e3, 6e3], "damping": [20.0, 30.0], "gravity": 9.81, "foundation": foundation}
    rows = moved({"carrier": carrier, "bodies": [ROTOR], "drive": DRIVE}, {"drum": 0.3, "carrier": {"x": 2e-3}})
    total, u, j, g = 5.0, 0.02, 0.02, 9.81
    c, b = np.array([4e3, 6e3]), np.array([20.0, 30.0])
    k = "xy".index(direction)
    down = g if direction == "y" else 0.0

    def rates(_t, s):
        q, (z, phi), v, (vz, w) = s[:2], s[2:4], s[4:6], s[6:]
        spring = -c * (q - z * np.eye(2)[k]) - b * (v - vz * np.eye(2)[k])
        e, n = np.array([math.cos(phi), math.sin(phi)]), np.array([-math.sin(phi), math.cos(phi)])
        matrix = np.zeros((3, 3))
        matrix[:2, :2], matrix[:2, 2], matrix[2, :2], matrix[2, 2] = total * np.eye(2), u * n, u * n, j
        right = [*(spring + u * w**2 * e - [0, total * g]), 0.05 * (60 - w) - u * g * math.cos(phi)]
        *a, aw = np.linalg.solve(matrix, right)
        az = (-3e4 * z - 50.0 * vz - spring[k] - 40.0 * down) / 40.0
        return [*v, vz, w, *a, az, aw]

    z0 = -(45.0 * g) / 3e4 if direction == "y" else 0.0
    y0 = z0 - total * g / 6e3
    begin = [2e-3, y0, z0, 0.3, 0, 0, 0, 0]
    other = solve_ivp(rates, (0, 1), begin, "DOP853", GRID, rtol=1e-13, atol=1e-15).y
    names = ("carrier.x", "carrier.y", f"foundation.{direction}", "drum.angle")
    for name, theirs in zip(names, other, strict=False):
        assert close(rows[name], theirs), name
    assert energy_gap(rows) < 1e-10
    assert "bearing_force_x" in rows


SHAKEN = {"directions": "xy", "mass": 3.0, "stiffness": 4e3, "damping": 20.0}


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


def test_a_harmonic_motion_beside_a_free_direction():
    """x is given, y swings freely: a mechanism whose masses are moved."""
    motion = {"direction": "x", "amplitude": 5e-3, "frequency": 31.0}
    rows = moved({"carrier": SHAKEN | {"motion": motion}, "bodies": [ROTOR], "drive": DRIVE}, {"drum": 0.2})
    m = Mechanism("y", "phi")
    y, phi = m.q
    x = 5e-3 * sp.cos(31 * TIME)
    m.mass(3.0, sp.Matrix([x, y]))
    m.mass(2.0, sp.Matrix([x, y]) + 0.01 * along(phi))
    m.turning(0.02 - 2.0 * 1e-4, phi)
    m.spring(4e3, y)
    m.damper(20.0, y)
    m.force(0.05 * (60 - m.rate(phi)), phi)
    other = m.motion([0.0, 0.2], [0.0, 0.0], GRID)
    assert close(rows["carrier.y"], other[0])
    assert close(rows["drum.angle"], other[1])
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


def test_a_carrier_that_rocks_about_the_normal():
    """Rotor at (0.3, -0.2) on a carrier that only turns: its axis moves by (-b chi, a chi)."""
    carrier = {"directions": "r", "inertia": 2.0, "rotation_stiffness": 900.0, "rotation_damping": 3.0, "gravity": 9.81}
    rows = moved(
        {"carrier": carrier, "bodies": [ROTOR | {"position": [0.3, -0.2], "bearing_damping": 0.01}], "drive": DRIVE},
        {"drum": 0.3},
    )
    m = Mechanism("chi", "phi")
    chi, phi = m.q
    m.turning(2.0, chi)
    m.mass(2.0, sp.Matrix([0.2 * chi, 0.3 * chi]) + 0.01 * along(phi), 9.81)
    m.turning(0.02 - 2e-4, phi)
    m.spring(900.0, chi)
    m.damper(3.0, chi)
    m.damper(0.01, phi - chi)
    m.force(0.05 * (60 - m.rate(phi)), phi)
    other = m.motion([-2.0 * 9.81 * 0.3 / 900.0, 0.3], [0.0, 0.0], GRID)
    assert close(rows["carrier.r"], other[0])
    assert close(rows["drum.angle"], other[1])
    assert energy_gap(rows) < 1e-10


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


def test_a_rocking_motion_that_is_given():
    carrier = {"directions": "r", "inertia": 0.5, "motion": {"direction": "r", "amplitude": "2 deg", "frequency": 20.0}}
    body = {"kind": "rotor", "name": "drum", "mass": 2.0, "inertia": 0.02, "couple_unbalance": 0.004}
    rows = moved({"carrier": carrier, "bodies": [body], "drive": DRIVE})
    size = math.radians(2)

    def rates(t, s):
        return [s[1], (0.05 * (60 - s[1]) - 0.004 * size * 400 * math.cos(20 * t) * math.sin(s[0])) / 0.02]

    other = solve_ivp(rates, (0, 1), [0, 0], "DOP853", GRID, rtol=1e-13, atol=1e-15).y
    assert rows["carrier.r"] == pytest.approx(size * np.cos(20 * GRID), abs=1e-13)
    assert close(rows["drum.angle"], other[0])
    assert energy_gap(rows) < 1e-10


def test_a_fixed_axis():
    """Without gravity the closed solution of the motor; with it, and no motor, the energy of a physical pendulum."""
    rows = moved({"carrier": {"directions": "fixed"}, "bodies": [ROTOR], "drive": DRIVE})
    assert rows["drum.speed"] == pytest.approx(60 * (1 - np.exp(-0.05 / 0.02 * GRID)), abs=1e-10)
    pendulum = moved({"carrier": {"directions": "fixed", "gravity": 9.81}, "bodies": [ROTOR]}, {"drum": 0.5})
    energy = 0.02 * pendulum["drum.speed"] ** 2 / 2 + 0.02 * 9.81 * np.sin(pendulum["drum.angle"])
    assert energy == pytest.approx(0.02 * 9.81 * math.sin(0.5), abs=1e-12)
    assert np.ptp(pendulum["drum.angle"]) > 3


@pytest.mark.parametrize(
    ("carrier", "body", "refusal"),
    [
        ({"directions": "xyr", "mass": 1.0, "inertia": 1.0}, {}, refused("machine.carrier.stiffness", code="missing")),
        ({"directions": "xyr", "mass": 1.0, "inertia": 1.0, "stiffness": 1.0, "mounts": MOUNTS}, {},
         refused("machine.carrier.mounts", code="either-or")),
        ({"directions": "xyr", "mass": 1.0, "inertia": 1.0, "mounts": [MOUNTS[2] | {"stiffness": [-1.0, 1.0]}]}, {},
         refused("machine.carrier.mounts", code="limits")),
        ({"directions": "xyr", "stiffness": 1.0, "inertia": 1.0}, {}, refused("machine.carrier.mass", code="missing")),
        ({"directions": "r", "inertia": 1.0}, {}, refused("machine.carrier.rotation_stiffness", given=None, code="missing")),
        ({"directions": "x"}, {}, refused("machine.carrier.stiffness", code="missing")),
        ({"stiffness": 1.0}, {"position": [0.1, 0.0]},
         refused("machine.bodies[0] (drum).position", "xyr", "xy", given=[0.1, 0.0])),
        ({"stiffness": 1.0}, {"eccentricity": None, "couple_unbalance": 0.1},
         refused("machine.bodies[0] (drum).couple_unbalance", "xy", given=0.1)),
        ({"stiffness": 1.0, "foundation": {"direction": "x", "mass": -1.0, "stiffness": 1.0}}, {},
         refused("machine.carrier.foundation.mass", code="limits")),
        ({"directions": "x", "stiffness": 1.0, "foundation": {"direction": "y", "mass": 1.0, "stiffness": 1.0}}, {},
         refused("machine.carrier.foundation", "x")),
        ({"directions": "x", "stiffness": 1.0, "motion": {"direction": "y", "amplitude": 1.0, "frequency": 1.0}}, {},
         refused("machine.carrier.motion", "x", code="direction")),
        ({"stiffness": 1.0, "motion": {"direction": "x", "amplitude": 1.0}}, {},
         refused("machine.carrier.motion", given={'direction': 'x', 'amplitude': 1.0}, code="either-or")),
        ({"directions": "round"}, {}, refused("machine.carrier.directions", code="unknown-name")),
    ],
)  # fmt: skip
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


def test_one_value_of_a_mount_holds_for_both_directions():
    """The same matrices as of a pair of equal ones; and it is one parameter."""
    one = [m | {"stiffness": 4e3, "damping": "3 N s/m"} for m in MOUNTS]
    pairs = [m | {"stiffness": [4e3, 4e3], "damping": [3.0, 3.0]} for m in MOUNTS]
    first, second = (machine_from(SCREEN | {"carrier": SCREEN["carrier"] | {"mounts": m}}) for m in (one, pairs))
    for a, b in zip(first.matrices, second.matrices, strict=True):
        assert a == pytest.approx(b, rel=1e-14)
    assert first.values["carrier.mounts.1.stiffness"] == 4e3
    softer = first.with_values({"carrier.mounts.1.stiffness": "2e3 N/m"})
    assert softer.matrices[2][0, 0] == pytest.approx(1e4)
    for wrong, refusal in (
        (-1.0, refused("machine.carrier.mounts", code="limits")),
        ([1.0], refused("machine.carrier.mounts[0].stiffness", given=[1.0], code="pair")),
        ("4 N", refused("machine.carrier.mounts[0].stiffness", given="4 N", code="dimension")),
    ):
        with refusal:
            machine_from(SCREEN | {"carrier": SCREEN["carrier"] | {"mounts": [MOUNTS[0] | {"stiffness": wrong}]}})


@pytest.mark.parametrize("frequency", ["5 Hz", ["5 Hz", "7 Hz"]])
def test_a_carrier_by_its_natural_frequency(frequency):
    """One value holds for x and y; the mass is that of all that moves, masses in guides too."""
    bodies = [
        ROTOR,
        {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.125, "length": 0.1, "damping": 0.01},
        {
            "kind": "slider",
            "name": "s",
            "about": "drum",
            "mass": 0.3,
            "angle": 0.0,
            "radius": 0.1,
            "stiffness": 1e4,
            "damping": 1.0,
        },
    ]
    carrier = {"mass": 3.0, "frequency": frequency, "damping_ratio": 0.1}
    machine = machine_from({"carrier": carrier, "bodies": bodies, "drive": DRIVE})
    hertz = np.array([5.0, 5.0] if isinstance(frequency, str) else [5.0, 7.0])
    mass, damping, stiffness = machine.matrices
    assert mass[0, 0] == pytest.approx(3 + 2 + 0.125 + 0.3)
    assert np.diag(stiffness) == pytest.approx(mass[0, 0] * (2 * math.pi * hertz) ** 2)
    assert np.diag(damping) == pytest.approx(2 * 0.1 * mass[0, 0] * 2 * math.pi * hertz)
    assert not {"carrier.frequency", "carrier.damping_ratio"} & set(machine.values)
    assert machine.notes[0].startswith("carrier: stiffness 535")


def test_a_frequency_and_a_stiffness_replace_each_other():
    document = {"carrier": {"stiffness": 1e4, "damping": 3.0}, "bodies": [ROTOR], "drive": DRIVE}
    machine = machine_from(document | {"set": {"carrier.frequency": "5 Hz", "carrier.damping_ratio": 0.1}})
    assert machine.values["carrier.stiffness"] == pytest.approx(2 * (10 * math.pi) ** 2)
    for wrong, refusal in (
        ({"frequency": "5 Hz"}, refused("machine.carrier.frequency", code="either-or")),
        ({"damping_ratio": 0.1}, refused("machine.carrier.damping_ratio", code="either-or")),
        ({"stiffness": None, "frequency": -3.0}, refused("machine.carrier.frequency", given=-3.0)),
    ):
        given = {k: v for k, v in (document["carrier"] | wrong).items() if v is not None}
        with refusal:
            machine_from(document | {"carrier": given})
