"""000, sections 4 and 5: synchronous states of two rollers and their stability."""

from __future__ import annotations

from functools import cache

import sympy as sp

from .check import Check, Claim, check, equal, reduced, turned
from .checks_rollers import A_XX, A_YY, ALPHA, OMEGA_X, OMEGA_Y, SOURCE, SPEED, F, rollers, turning_back
from .derived import real

F_0, F_1, F_2 = F
FIRST, SECOND = ALPHA[1:]
TOGETHER = A_XX + A_YY
AREA = real("S")[0]
"""S = 2 f_0 f_1 sin(gamma_1) = 2 f_0 f_2 sin(gamma_2): four times the area of the triangle of forces, by Heron's formula."""
SIDES = (F_0 + F_1 + F_2) * (-F_0 + F_1 + F_2) * (F_0 - F_1 + F_2) * (F_0 + F_1 - F_2)
OF_AREA = ((AREA, AREA**2 - SIDES),)
GAMMA = real("gamma_1 gamma_2")
COSINES = ((F_0**2 + F_1**2 - F_2**2) / (2 * F_0 * F_1), (F_0**2 - F_1**2 + F_2**2) / (2 * F_0 * F_2))  # (42)
SINES = (AREA / (2 * F_0 * F_1), AREA / (2 * F_0 * F_2))
TRIANGLE = dict(zip(GAMMA, zip(SINES, COSINES, strict=True), strict=True))


@cache
def torques() -> sp.Matrix:
    """What turns the rollers back, over (A_xx + A_yy)/2."""
    return sp.Matrix([reduced(2 * turning_back(i) / TOGETHER) for i in (1, 2)])


@cache
def stiffness() -> sp.Matrix:
    """K of (52): the Jacobian of the moments over f_i, which is twice that of the averaged equations."""
    rows = sp.Matrix([torques()[i] / F[i + 1] for i in range(2)])
    return TOGETHER * rows.jacobian([FIRST, SECOND])


def balanced(expression: sp.Expr, sign: int = 1) -> sp.Expr:
    """At the compensating phases (43), or (44) with sign -1."""
    put = {FIRST: sp.pi - sign * GAMMA[0], SECOND: sp.pi + sign * GAMMA[1]}
    return turned(expression.xreplace(put), TRIANGLE)


@check(SOURCE, "(34), (35)", "(0, 0)", "Where phases are constant: the moments over f_i (A_xx + A_yy)/2.")
def equations_34_and_35() -> Claim:
    apart = sp.sin(FIRST - SECOND)
    printed = sp.ImmutableMatrix([F_0 * sp.sin(FIRST) + F_2 * apart, F_0 * sp.sin(SECOND) - F_1 * apart])
    return equal(printed, sp.Matrix([torques()[i] / F[i + 1] for i in range(2)]))


BALANCE_ACROSS = F_1 * sp.sin(FIRST) + F_2 * sp.sin(SECOND)
BALANCE_ALONG = F_0 + F_1 * sp.cos(FIRST) + F_2 * sp.cos(SECOND)


@check(SOURCE, "(36)", "0", "The sum of (34) f_1 and (35) f_2, over f_0.")
def equation_36() -> Claim:
    return equal(BALANCE_ACROSS, (torques()[0] + torques()[1]) / F_0)


@check(SOURCE, "(37)", "0", "With (36): the residual is (34) less sin(alpha_1) (37) and plus cos(alpha_1) (36).")
def equation_37() -> Claim:
    return Claim(BALANCE_ALONG, lambda e: torques()[0] / F_1 - sp.sin(FIRST) * e + sp.cos(FIRST) * BALANCE_ACROSS)


@check(
    SOURCE,
    "(38)",
    "(f_2^2, f_1^2)",
    "From (36), (37): the residual is the square of the resultant of the other two forces, less the printed.",
)
def equation_38() -> Claim:
    printed = [F_0**2 + 2 * F_0 * f * sp.cos(a) + f**2 for f, a in ((F_1, FIRST), (F_2, SECOND))]
    squares = [(F_0 + f * sp.cos(a)) ** 2 + (f * sp.sin(a)) ** 2 for f, a in ((F_1, FIRST), (F_2, SECOND))]
    return equal(sp.ImmutableMatrix(printed), sp.Matrix(squares))


@check(
    SOURCE,
    "(39), (42), (43)",
    r"(\alpha_1, \alpha_2)",
    "The first compensating state, with the cosines (39) of gamma_1, gamma_2: the residual is (34), (35).",
)
def equation_43() -> Claim:
    return _compensating(1)


@check(SOURCE, "(44)", r"(\alpha_1, \alpha_2)", "The second compensating state.")
def equation_44() -> Claim:
    return _compensating(-1)


def _compensating(sign: int) -> Claim:
    state = sp.ImmutableMatrix([sp.pi - sign * GAMMA[0], sp.pi + sign * GAMMA[1]])

    def at(e: sp.Matrix) -> sp.Matrix:
        return torques().applyfunc(lambda v: turned(v.xreplace({FIRST: e[0], SECOND: e[1]}), TRIANGLE))

    return Claim(state, at, relations=OF_AREA)


@check(
    SOURCE,
    "(41)",
    r"4 f_0^2 f_1^2 - (f_0^2 + f_1^2 - f_2^2)^2",
    "The triangle inequality is (40): the residual is 4 f_0^2 f_1^2 - (f_0^2 + f_1^2 - f_2^2)^2 less the product of its sides.",
)
def equation_41() -> Claim:
    return equal(SIDES, 4 * F_0**2 * F_1**2 - (F_0**2 + F_1**2 - F_2**2) ** 2)


@check(SOURCE, "(45) to (48)", r"(\alpha_1, \alpha_2)", "The states on one line, one a column: the residual is (34), (35).")
def equations_45_to_48() -> Claim:
    pi, zero = sp.pi, sp.S.Zero

    def at(states: sp.Matrix) -> sp.Matrix:
        columns = [torques().subs({FIRST: states[0, k], SECOND: states[1, k]}) for k in range(4)]
        return sp.Matrix.hstack(*columns)

    return Claim(sp.ImmutableMatrix([[zero, pi, zero, pi], [zero, pi, pi, zero]]), at)


@check(
    SOURCE, "(49), (50)", r"\Omega^2", "Where A_xx + A_yy changes its sign: the residual is 1/A_xx, A_xx + A_yy, 1/A_yy there."
)
def equations_49_and_50() -> Claim:
    d = rollers(short=False)
    influence = [reduced(d.definition(f"H[{n}].re")) for n in ("x", "y")]
    conditions = [1 / influence[0], influence[0] + influence[1], 1 / influence[1]]
    printed = sp.ImmutableMatrix([OMEGA_X**2, (OMEGA_X**2 + OMEGA_Y**2) / 2, OMEGA_Y**2])
    size = sp.Symbol("size", positive=True)
    actual = [sp.cancel(c).subs(SPEED, sp.sqrt(size)) for c in conditions]
    return Claim(printed, lambda e: sp.Matrix([c.subs(size, v) for c, v in zip(actual, e, strict=True)]))


COSINE = sp.cos(FIRST - SECOND)


@check(
    SOURCE, "(51)", r"\bar K", "The equations in variations of (32), (33): minus twice the Jacobian of the vibration torques."
)
def equation_51() -> Claim:
    pair = F_1 * F_2 * COSINE
    printed = [[F_0 * F_1 * sp.cos(FIRST) + pair, -pair], [-pair, F_0 * F_2 * sp.cos(SECOND) + pair]]
    return equal(TOGETHER * sp.ImmutableMatrix(printed), TOGETHER * torques().jacobian([FIRST, SECOND]))


@check(SOURCE, "(52)", "K", "(51) with row i over f_i.")
def equation_52() -> Claim:
    first, second = F_0 * sp.cos(FIRST) + F_2 * COSINE, F_0 * sp.cos(SECOND) + F_1 * COSINE
    return equal(TOGETHER * sp.ImmutableMatrix([[first, -F_2 * COSINE], [-F_1 * COSINE, second]]), stiffness())


@check(SOURCE, "(53), (54)", r"(K_{11}, K_{22})/(A_{xx}+A_{yy})", "The diagonal of (52) in the compensating states.")
def equations_53_and_54() -> Claim:
    return equal(
        sp.ImmutableMatrix([-F_1, -F_2]),
        sp.Matrix([balanced(stiffness()[i, i] / TOGETHER) for i in range(2)]),
        relations=OF_AREA,
    )


@check(SOURCE, "(55)", "K", "(52) in the compensating states.")
def equation_55() -> Claim:
    printed = TOGETHER * sp.ImmutableMatrix([[-F_1, -F_2 * COSINE], [-F_1 * COSINE, -F_2]])
    return Claim(printed, lambda e: (stiffness() - e).applyfunc(balanced), relations=OF_AREA)


@check(SOURCE, "(56), (57)", r"(K_{11}, \det K)", "The leading minors of (52) in the compensating states.")
def equations_56_and_57() -> Claim:
    printed = sp.ImmutableMatrix([-TOGETHER * F_1, TOGETHER**2 * F_1 * F_2 * sp.sin(FIRST - SECOND) ** 2])
    minors = sp.Matrix([stiffness()[0, 0], stiffness().det()])
    return Claim(printed, lambda e: (minors - e).applyfunc(balanced), relations=OF_AREA)


def on_a_line(
    state: str, cosines: tuple[int, int], numbers: tuple[str, str], matrix: sp.Matrix, minors: sp.Matrix
) -> tuple[Check, Check]:
    """K in one of the states (45) to (47) and its leading minors, as printed."""
    at = {FIRST: sp.acos(cosines[0]), SECOND: sp.acos(cosines[1])}

    def of_matrix() -> Claim:
        return equal(sp.ImmutableMatrix(TOGETHER * matrix), stiffness().subs(at))

    def of_minors() -> Claim:
        actual = stiffness().subs(at)
        return equal(sp.ImmutableMatrix(minors), sp.Matrix([actual[0, 0], actual.det()]))

    return (
        check(SOURCE, numbers[0], "K", f"(52) in the state {state}.")(of_matrix),
        check(
            SOURCE,
            numbers[1],
            r"(K_{11}, \det K)",
            f"Its leading minors, which are positive where the state {state} is stable.",
        )(of_minors),
    )


AMPLIFIED, AMPLIFIED_MINORS = on_a_line(
    "(45)",
    (1, 1),
    ("(59)", "(60), (61)"),
    sp.Matrix([[F_0 + F_2, -F_2], [-F_1, F_0 + F_1]]),
    sp.Matrix([TOGETHER * (F_0 + F_2), TOGETHER**2 * F_0 * (F_0 + F_1 + F_2)]),
)
OPPOSED, OPPOSED_MINORS = on_a_line(
    "(46)",
    (-1, -1),
    ("(63)", "(64), (65)"),
    sp.Matrix([[-F_0 + F_2, -F_2], [-F_1, -F_0 + F_1]]),
    sp.Matrix([TOGETHER * (-F_0 + F_2), TOGETHER**2 * F_0 * (F_0 - F_1 - F_2)]),
)
APART, APART_MINORS = on_a_line(
    "(47)",
    (1, -1),
    ("(67)", "(68), (69)"),
    sp.Matrix([[F_0 - F_2, F_2], [F_1, -F_0 - F_1]]),
    sp.Matrix([TOGETHER * (F_0 - F_2), TOGETHER**2 * F_0 * (-F_0 - F_1 + F_2)]),
)


@check(
    SOURCE,
    "(66), (70)",
    r"(f_1 + f_2, f_0 + f_1)",
    "Where (65) and (69) change their sign: the residual is these minors at the limits, f_0 and f_2.",
)
def equations_66_and_70() -> Claim:
    states = ({FIRST: sp.pi, SECOND: sp.pi}, {FIRST: sp.S.Zero, SECOND: sp.pi})
    opposed, apart = (stiffness().subs(s).det() for s in states)
    limits = sp.ImmutableMatrix([F_0, F_2])
    return Claim(limits, lambda e: sp.Matrix([opposed.subs(F_1, e[0] - F_2), apart.subs(F_1, e[1] - F_0)]))


@check(
    SOURCE,
    "Table 3",
    r"(\alpha_1^*, \alpha_2^*)",
    "Its last row, asymptotically stable where A_xx + A_yy < 0, for unbalances of 2e-4 and 5e-5 on 1e-4 kg m: the state where "
    "the minors of (52) are positive. The printed one belongs to f_2 > f_0 + f_1; Bild 10 has the right one.",
)
def table_3() -> Claim:
    unbalances = {F_0: sp.Integer(1), F_1: sp.Integer(2), F_2: sp.Rational(1, 2)}
    below = (-stiffness() / TOGETHER).applyfunc(reduced).subs(unbalances)

    def stable(state: sp.Matrix) -> bool:
        actual = below.subs({FIRST: state[0], SECOND: state[1]})
        return bool(actual[0, 0] > 0 and actual.det() > 0)

    states = [sp.ImmutableMatrix([a, b]) for a in (0, sp.pi) for b in (0, sp.pi)]
    (actual,) = (state for state in states if stable(state))
    return equal(sp.ImmutableMatrix([0, sp.pi]), actual, sp.ImmutableMatrix([sp.pi, 0]))
