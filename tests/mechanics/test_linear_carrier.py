"""M, C, K of the carrier and what a turning body does to it, read off the same energies."""

import sympy as sp
from tests.refusals import rejected

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


def test_a_coupling_with_a_mean_excites_by_its_wave_alone():
    """A body whose coupling is a + b cos(phi): turning steadily at w it excites as -i b w^2 exp(i phi), a does nothing."""
    a, b = sp.symbols("a b", positive=True)
    body = Energies(kinetic=vx * (a + b * sp.cos(phi.position)) * w + J * w**2 / 2)
    carrier = linear_carrier([SUPPORT, body], [x, y], [phi])
    assert carrier.coupling[0] == sp.Matrix([a + b * sp.cos(phi.position), 0])
    assert carrier.excitation[0].applyfunc(sp.expand) == sp.Matrix([-sp.I * b, 0])
