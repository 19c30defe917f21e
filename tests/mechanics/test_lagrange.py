"""Euler-Lagrange: from energies to the equations that stand in textbooks, with no residual left."""

import sympy as sp
from tests.refusals import rejected

from wucht.mechanics.energies import AppliedForce, Energies
from wucht.mechanics.lagrange import (
    Coordinate,
    Lock,
    acceleration,
    dissipated_power,
    equations_of_motion,
    first_order,
    reaction,
    supplied_power,
)
from wucht.mechanics.notation import Notation, equation_text, printed_equations
from wucht.system import TIME, System

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
    kinetic=M * x.velocity**2 / 2,
    dissipation=b * x.velocity**2 / 2,
    applied_forces=(AppliedForce(F, x.velocity, "push"),),
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


def test_a_pivot_that_shakes_adds_to_gravity():
    """Kapitza's pendulum: a kinetic energy that depends on time and is linear in the velocity besides quadratic."""
    lift = sp.diff(F * cos(Omega * TIME), TIME)
    th, w = theta.position, theta.velocity
    shaken = Energies(kinetic=m * ((l * w * cos(th)) ** 2 + (l * w * sin(th) + lift) ** 2) / 2, potential=-m * g * l * cos(th))
    motion = equations_of_motion([shaken], [theta])
    assert nothing_left(motion.mass - sp.Matrix([m * l**2]))
    assert nothing_left(motion.forces + sp.Matrix([m * l * (g + sp.diff(lift, TIME)) * sin(th)]))


def test_a_turning_table_gives_coriolis_and_centrifugal_force():
    y = Coordinate.from_names("y", "vy")
    turning = ((x.velocity - Omega * y.position) ** 2 + (y.velocity + Omega * x.position) ** 2) / 2
    motion = equations_of_motion([Energies(kinetic=m * turning)], [x, y])
    expected = m * sp.Matrix([2 * Omega * y.velocity + Omega**2 * x.position, -2 * Omega * x.velocity + Omega**2 * y.position])
    assert nothing_left(motion.forces - expected)


def test_the_order_of_parts_and_their_number_do_not_matter():
    whole = Energies(
        CART.kinetic + HANGING.kinetic,
        CART.potential + HANGING.potential,
        CART.dissipation + HANGING.dissipation,
        CART.applied_forces,
    )
    together = equations_of_motion([whole], [x, theta])
    apart = equations_of_motion([HANGING, CART], [x, theta])
    assert nothing_left(together.mass - apart.mass)
    assert nothing_left(together.forces - apart.forces)


def test_a_kinetic_energy_that_is_not_quadratic_is_refused():
    for kinetic in (x.velocity**3, x.velocity**4, x.velocity**2 * theta.velocity, sp.sqrt(1 + x.velocity**2)):
        with rejected("not-quadratic"):
            equations_of_motion([Energies(kinetic=kinetic)], [x, theta])


def test_first_order_form_solves_the_second_order_form():
    motion = equations_of_motion([CART, HANGING], [x, theta])
    system = first_order(motion, [x, theta], [M, m, l, g, b, F])
    assert system.state_names == ("x", "theta", "vx", "omega")
    assert system.angles == {theta.position}
    assert [system.explicit(d) for d in system.derivatives[:2]] == [x.velocity, theta.velocity]
    accelerations = sp.Matrix([system.explicit(d) for d in system.derivatives[2:]])
    assert nothing_left(motion.mass * accelerations - motion.forces)


def test_an_expression_with_an_unknown_symbol_is_refused():
    with rejected("unknown-symbol", "x", "c"):
        System((x.position,), (c * x.position,))


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


def test_a_pendulum_locked_to_a_shaft_that_speeds_up_follows_it():
    """Locked, its acceleration is that of the shaft, and the cart feels it as if the pendulum were part of the shaft."""
    shaft = Coordinate.from_names("theta", "omega", angle=True, prescribed_velocity=Omega * TIME)
    locked = sp.Symbol("locked", real=True)
    follows = {theta.position: alpha.position, theta.velocity: alpha.velocity}
    hanging = Energies(kinetic=HANGING.kinetic.subs(follows), potential=HANGING.potential.subs(follows))
    motion = equations_of_motion([CART, hanging], [x, shaft, alpha])
    locks = [Lock(2, 1, locked)]
    system = first_order(motion, [x, shaft, alpha], [M, m, l, g, b, F, Omega, locked], locks=locks)
    al, w, vx = alpha.position, alpha.velocity, x.velocity
    cart = (m * l * sin(al) * w**2 - b * vx + F - m * l * cos(al) * Omega) / (M + m)
    assert sp.simplify(system.explicit(acceleration(x)).subs(locked, 1) - cart) == 0
    assert sp.simplify(system.explicit(acceleration(alpha)).subs(locked, 1) - Omega) == 0
    torque = m * l**2 * Omega + m * l * cos(al) * cart + m * g * l * sin(al)
    assert sp.simplify(system.explicit(reaction(shaft)).subs(locked, 1) - torque) == 0
    free = sp.solve(
        [(M + m) * sp.Symbol("X") + m * l * cos(al) * sp.Symbol("A") - m * l * sin(al) * w**2 + b * vx - F,
         m * l**2 * sp.Symbol("A") + m * l * cos(al) * sp.Symbol("X") + m * g * l * sin(al)], [sp.Symbol("X"), sp.Symbol("A")],
    )  # fmt: skip
    assert sp.simplify(system.explicit(acceleration(x)).subs(locked, 0) - free[sp.Symbol("X")]) == 0


def test_power_is_booked_on_its_side():
    brake = Energies(applied_forces=(AppliedForce(-c * theta.velocity, theta.velocity, "brake", energy_side="lost"),))
    parts = [CART, HANGING, brake]
    assert sp.expand(supplied_power(parts, [x, theta]) - F * x.velocity) == 0
    assert sp.expand(dissipated_power(parts, [x, theta]) - b * x.velocity**2 - c * theta.velocity**2) == 0


def test_an_enforced_speed_supplies_power():
    driven = Coordinate.from_names("theta", "omega", angle=True, prescribed_velocity=Omega)
    assert supplied_power([CART, HANGING], [x, driven]) == F * x.velocity + reaction(driven) * driven.velocity


def test_equations_that_are_written_with_their_inertia_divided_out() -> None:
    """4 x'' = 6 F - 2 x: as it is, and as x'' = 3/2 F - x/2."""
    q = Coordinate.from_names("x", "v")
    F = sp.Symbol("F", real=True)
    motion = equations_of_motion([Energies(kinetic=2 * q.velocity**2, potential=q.position**2 - 6 * F * q.position)], [q])
    names = Notation({"x": "x", "F": "F"})
    equations = [printed_equations(motion, [q], names, [], False, normalise)[0] for normalise in (False, True)]
    lines = [equation_text(equation, latex=False).replace(" ", "") for equation in equations]
    left, right = zip(*(line.split("=") for line in lines), strict=True)
    assert left[0].startswith("4*")
    assert not left[1].startswith("4*")
    values = [sp.sympify(side).subs({"x": 5, "F": 7}) for side in right]
    assert values == [32, 8]
