"""Euler-Lagrange: from energies to the equations that stand in textbooks, with no residual left."""

import sympy as sp
from tests.refusals import rejected

from wucht.mechanics.energies import AppliedForce, Energies
from wucht.mechanics.lagrange import (
    Coordinate,
    acceleration,
    dissipated_power,
    equations_of_motion,
    first_order,
    reaction,
    supplied_power,
)
from wucht.system import TIME

sin, cos = sp.sin, sp.cos
M, m, m1, m2, l, l1, l2, g, b, c, F, Omega = sp.symbols("M m m1 m2 l l1 l2 g b c F Omega", positive=True)  # noqa: E741
x, theta, alpha, beta = (
    Coordinate.from_names("x", "vx"),
    Coordinate.from_names("theta", "omega", angle=True),
    Coordinate.from_names("alpha", "v_alpha", angle=True),
    Coordinate.from_names("beta", "v_beta", angle=True),
)

# A cart of mass M on a rail, pushed by F and braked by b; a pendulum hangs from it, theta measured from straight down.
CART = Energies(
    kinetic=M * x.velocity**2 / 2, dissipation=b * x.velocity**2 / 2, applied_forces=(AppliedForce(F, x.velocity, "push"),)
)
HANGING = Energies(
    kinetic=m
    * ((x.velocity + l * theta.velocity * cos(theta.position)) ** 2 + (l * theta.velocity * sin(theta.position)) ** 2)
    / 2,
    potential=-m * g * l * cos(theta.position),
)


def nothing_left(matrix):
    return sp.simplify(matrix) == sp.zeros(*matrix.shape)


def test_pendulum_on_a_cart():
    motion = equations_of_motion([CART, HANGING], [x, theta])
    th, w, vx = theta.position, theta.velocity, x.velocity
    assert nothing_left(motion.mass - sp.Matrix([[M + m, m * l * cos(th)], [m * l * cos(th), m * l**2]]))
    assert nothing_left(motion.forces - sp.Matrix([m * l * sin(th) * w**2 - b * vx + F, -m * g * l * sin(th)]))


def test_double_pendulum():
    a, va, be, vb = alpha.position, alpha.velocity, beta.position, beta.velocity
    upper = Energies(kinetic=m1 * l1**2 * va**2 / 2, potential=-m1 * g * l1 * cos(a))
    lower = Energies(
        kinetic=m2 * ((l1 * va * cos(a) + l2 * vb * cos(be)) ** 2 + (l1 * va * sin(a) + l2 * vb * sin(be)) ** 2) / 2,
        potential=-m2 * g * (l1 * cos(a) + l2 * cos(be)),
    )
    motion = equations_of_motion([upper, lower], [alpha, beta])
    coupling = m2 * l1 * l2 * cos(a - be)
    assert nothing_left(motion.mass - sp.Matrix([[(m1 + m2) * l1**2, coupling], [coupling, m2 * l2**2]]))
    swing = m2 * l1 * l2 * sin(a - be)
    expected = sp.Matrix([-swing * vb**2 - (m1 + m2) * g * l1 * sin(a), swing * va**2 - m2 * g * l2 * sin(be)])
    assert nothing_left(motion.forces - expected)


def test_a_kinetic_energy_that_is_not_quadratic_is_refused():
    for kinetic in (x.velocity**3, x.velocity**4, x.velocity**2 * theta.velocity, sp.sqrt(1 + x.velocity**2)):
        with rejected("not-quadratic"):
            equations_of_motion([Energies(kinetic=kinetic)], [x, theta])


def test_reaction_torque_of_a_pendulum_turned_at_a_given_speed():
    """A pendulum on a sprung cart is driven with speed Omega t: its motor gives what inertia, cart and gravity ask for."""
    driven = Coordinate.from_names("theta", "omega", angle=True, prescribed_velocity=Omega * TIME)
    spring = Energies(potential=c * x.position**2 / 2)
    motion = equations_of_motion([CART, HANGING, spring], [x, driven])
    system = first_order(motion, [x, driven], [M, m, l, g, b, F, c, Omega])
    assert motion.driven == (theta.position,)
    assert system.state_names == ("x", "theta", "vx")  # the given speed is no state
    th, w, x_, vx = theta.position, Omega * TIME, x.position, x.velocity
    cart = (m * l * sin(th) * w**2 - b * vx - c * x_ + F - m * l * cos(th) * Omega) / (M + m)
    assert sp.simplify(system.explicit(acceleration(x)) - cart) == 0
    torque = m * l**2 * Omega + m * l * cos(th) * cart + m * g * l * sin(th)
    assert sp.simplify(system.explicit(reaction(driven)) - torque) == 0


def test_power_is_booked_on_its_side():
    brake = Energies(applied_forces=(AppliedForce(-c * theta.velocity, theta.velocity, "brake", energy_side="lost"),))
    parts = [CART, HANGING, brake]
    assert sp.expand(supplied_power(parts, [x, theta]) - F * x.velocity) == 0
    assert sp.expand(dissipated_power(parts, [x, theta]) - b * x.velocity**2 - c * theta.velocity**2) == 0
