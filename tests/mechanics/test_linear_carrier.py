"""M, C, K of the carrier and what a turning body does to it, read off the same energies."""

import sympy as sp
from tests.refusals import rejected

from wucht.files.building import machine_from
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.mechanics.linear_carrier import linear_carrier

x, y, phi = Coordinate.from_names("x", "vx"), Coordinate.from_names("y", "vy"), Coordinate.from_names("phi", "w", angle=True)
m0, m, U, J, kx, ky, k12, bx, by, g = sp.symbols("m0 m U J kx ky k12 bx by g", positive=True)
vx, vy, w = x.velocity, y.velocity, phi.velocity

SUPPORT = Energies(
    kinetic=m0 * (vx**2 + vy**2) / 2,
    potential=kx * x.position**2 / 2 + ky * y.position**2 / 2 + k12 * x.position * y.position + m0 * g * y.position,
    dissipation=bx * vx**2 / 2 + by * vy**2 / 2,
)
ROTOR = Energies(
    kinetic=m * (vx**2 + vy**2) / 2 + U * w * (-vx * sp.sin(phi.position) + vy * sp.cos(phi.position)) + J * w**2 / 2,
    potential=g * (m * y.position + U * sp.sin(phi.position)),
)


def test_matrices_of_a_rotor_on_springs():
    carrier = linear_carrier([SUPPORT, ROTOR], [x, y], [phi])
    assert carrier.mass == sp.Matrix([[m0 + m, 0], [0, m0 + m]])
    assert carrier.damping == sp.Matrix([[bx, 0], [0, by]])
    assert carrier.stiffness == sp.Matrix([[kx, k12], [k12, ky]])
    assert carrier.load.applyfunc(sp.expand) == sp.Matrix([0, -(m0 + m) * g]).applyfunc(sp.expand)


def test_a_rotor_excites_with_U_times_1_and_minus_i():
    """Re[U (1, -i) w^2 exp(i phi)] = U w^2 (cos phi, sin phi): the centrifugal force points to the centre of mass."""
    carrier = linear_carrier([SUPPORT, ROTOR], [x, y], [phi])
    assert carrier.coupling[0] == sp.Matrix([-U * sp.sin(phi.position), U * sp.cos(phi.position)])
    assert carrier.excitation[0] == sp.Matrix([U, -sp.I * U])
    turning = (carrier.excitation[0] * w**2 * sp.exp(sp.I * phi.position)).applyfunc(lambda e: sp.re(e.expand(complex=True)))
    assert turning == U * w**2 * sp.Matrix([sp.cos(phi.position), sp.sin(phi.position)])


def test_a_body_mounted_at_an_angle_excites_with_a_phase():
    ahead = ROTOR.kinetic.subs(phi.position, phi.position + sp.pi / 3)
    excitation = linear_carrier([Energies(kinetic=ahead)], [x, y], [phi]).excitation[0]
    expected = U * sp.exp(sp.I * sp.pi / 3) * sp.Matrix([1, -sp.I])
    assert (excitation - expected).applyfunc(lambda e: sp.simplify(e.expand(complex=True))) == sp.zeros(2, 1)


def test_one_direction_only():
    carrier = linear_carrier([Energies(kinetic=m * vx**2 / 2 - U * w * vx * sp.sin(phi.position))], [x], [phi])
    assert carrier.mass == sp.Matrix([m])
    assert carrier.excitation[0] == sp.Matrix([U])


def test_a_carrier_that_is_not_linear_is_refused():
    hardening = Energies(potential=kx * x.position**4)
    with rejected("not-constant", "stiffness"):
        linear_carrier([SUPPORT, ROTOR, hardening], [x, y], [phi])
    rubbing = Energies(dissipation=bx * vx**4)
    with rejected("not-constant", "damping"):
        linear_carrier([SUPPORT, ROTOR, rubbing], [x, y], [phi])
    moving_inertia = Energies(kinetic=m * sp.cos(phi.position) ** 2 * vx**2)
    with rejected("not-constant", "mass"):
        linear_carrier([SUPPORT, ROTOR, moving_inertia], [x, y], [phi])


def test_a_machine_with_a_pendulum_and_a_roller():
    machine = machine_from(
        {
            "carrier": {"mass": 1.0, "stiffness": [4.0, 9.0], "damping": [0.4, 0.6], "gravity": 9.81},
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.1, "inertia": 0.5},
                {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.5, "length": 0.2},
                {"kind": "roller", "name": "r", "about": "drum", "mass": 0.25, "track_radius": 0.3, "radius": 0.1},
            ],
        }
    )
    carrier, at = machine.linear_carrier, machine.numbers
    assert carrier.mass.xreplace(at) == 3.75 * sp.eye(2)
    assert carrier.stiffness.xreplace(at) == sp.diag(4.0, 9.0)
    assert carrier.damping.xreplace(at) == sp.diag(0.4, 0.6)
    strengths = [complex(e[0].xreplace(at)) for e in carrier.excitation]
    assert [abs(s) for s in strengths] == [0.2, 0.1, 0.25 * (0.3 - 0.1)]
    assert all(complex(e[1].xreplace(at)) == -1j * s for e, s in zip(carrier.excitation, strengths, strict=True))
    assert [float(f) for f in carrier.load.xreplace(at)] == [0.0, -3.75 * 9.81]


def test_a_coupling_with_a_mean_excites_by_its_wave_alone():
    """A body whose coupling is a + b cos(phi): turning steadily at w it excites as -i b w^2 exp(i phi), a does nothing."""
    a, b = sp.symbols("a b", positive=True)
    body = Energies(kinetic=vx * (a + b * sp.cos(phi.position)) * w + J * w**2 / 2)
    carrier = linear_carrier([SUPPORT, body], [x, y], [phi])
    assert carrier.coupling[0] == sp.Matrix([a + b * sp.cos(phi.position), 0])
    assert carrier.excitation[0].applyfunc(sp.expand) == sp.Matrix([-sp.I * b, 0])
