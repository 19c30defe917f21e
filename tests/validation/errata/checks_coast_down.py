"""001, section 3: a disc with two damped sliders that coasts down under gravity."""

from __future__ import annotations

from functools import cache

import sympy as sp

from wucht.mechanics.lagrange import equations_of_motion
from wucht.mechanics.means import mean

from .check import Claim, check, equal, reduced
from .derived import full_rows, path, real
from .machines import disc_with_sliders

SOURCE = "001"
SPEED, THETA, J_0, M, G, R, NATURAL, DELTA = real(r"Omega theta J_0 m g R \omega_{st} delta")
"""THETA is Omega t, as in (67) counted from the vertical; NATURAL^2 = c/m and DELTA = b/(2 m) of (73)."""
SLIDERS = ("s1", "s2")
PUT = {path("disc.inertia"): J_0, path("disc.unbalance"): sp.S.Zero, path("disc.bearing_damping"): sp.S.Zero}
PUT |= {path("carrier.gravity"): G, path("disc.angle"): THETA + sp.pi / 2, path("disc.speed"): SPEED}
for _name, _angle in zip(SLIDERS, (sp.S.Zero, sp.pi), strict=True):
    PUT |= {path(f"{_name}.mass"): M, path(f"{_name}.radius"): R, path(f"{_name}.angle"): _angle}
    PUT |= {path(f"{_name}.stiffness"): M * NATURAL**2, path(f"{_name}.damping"): 2 * M * DELTA}


@cache
def rows() -> dict[str, sp.Expr]:
    """The full equations M a - F, the disc turning with Omega."""
    steady = {path("disc.angle.acceleration"): sp.S.Zero}
    return {name: row.xreplace(steady) for name, row in full_rows(disc_with_sliders(), PUT).items()}


def moving(displacements: tuple[sp.Expr, ...], row: str) -> sp.Expr:
    """A row for displacements that are functions of theta = Omega t."""
    put = dict[sp.Symbol, sp.Expr]()
    for name, x in zip(SLIDERS, displacements, strict=True):
        put |= {path(f"{name}.displacement"): x, path(f"{name}.velocity"): SPEED * sp.diff(x, THETA)}
        put[path(f"{name}.displacement.acceleration")] = SPEED**2 * sp.diff(x, THETA, 2)
    return rows()[row].xreplace(put)


@cache
def displacements() -> tuple[sp.Expr, sp.Expr]:
    """The periodic solutions at a constant speed."""
    still, cosine, sine = real("X a b")
    actual = []
    for name in SLIDERS:
        x = still + cosine * sp.cos(THETA) + sine * sp.sin(THETA)
        row = sp.expand(sp.expand_trig(moving((x, x), f"{name}.displacement")))
        waves = [row.coeff(f) for f in (sp.cos(THETA), sp.sin(THETA))]
        rest = sp.expand(row - waves[0] * sp.cos(THETA) - waves[1] * sp.sin(THETA))
        actual.append(x.xreplace(sp.solve([rest, *waves], [still, cosine, sine], dict=True)[0]))
    return actual[0], actual[1]


DETUNED = (NATURAL**2 - 2 * SPEED**2) ** 2 + 4 * DELTA**2 * SPEED**2
STRETCHED = NATURAL**2 * R / (NATURAL**2 - SPEED**2)


@check(
    SOURCE,
    "(72), (73)",
    "(x_1, x_2)",
    "The sliders at a constant speed, theta = Omega t; cos and sin of Phi from (73): the residual is (64).",
)
def equations_72_and_73() -> Claim:
    wave = G / DETUNED * ((NATURAL**2 - 2 * SPEED**2) * sp.cos(THETA) + 2 * DELTA * SPEED * sp.sin(THETA))
    still = SPEED**2 / (NATURAL**2 - SPEED**2) * R
    printed = sp.ImmutableMatrix([still - wave, still + wave])
    return Claim(printed, lambda e: sp.Matrix([moving(tuple(e), f"{n}.displacement") for n in SLIDERS]))


BRAKE = -M * G**2 * 2 * DELTA * SPEED / DETUNED


@check(
    SOURCE,
    "(75), right of (77)",
    r"-m g \Delta \sin\Phi",
    "The mean torque on the disc: the program's full equation with these displacements, averaged over a turn.",
)
def equation_75() -> Claim:
    row = sp.expand(sp.expand_trig(moving(displacements(), "disc.angle")))
    return equal(BRAKE, -mean(row, THETA))


@check(
    SOURCE,
    "(77) bracket",
    r"[\,\cdot\,]",
    "What meets dOmega/dt: the derivative of the angular momentum by Omega. The sliders move inwards as the speed falls.",
)
def equation_77() -> Claim:
    machine = disc_with_sliders()
    inertia = equations_of_motion(machine.energies, machine.coordinates).mass[0, 0].xreplace(PUT)
    still = [mean(x, THETA) for x in displacements()]
    at_rest = {path(f"{n}.displacement"): x for n, x in zip(SLIDERS, still, strict=True)}
    derived = sp.diff(reduced(inertia.xreplace(at_rest)) * SPEED, SPEED)
    printed = J_0 + 2 * M * STRETCHED**2
    following = 8 * M * R**2 * NATURAL**4 * SPEED**2 / (NATURAL**2 - SPEED**2) ** 3
    return equal(printed, derived, printed + following)


@check(
    SOURCE,
    "(80)",
    "k_R",
    "The bearing damping that (77) comes to at slow speeds: minus the slope of its right-hand side at rest.",
)
def equation_80() -> Claim:
    row = sp.expand(sp.expand_trig(moving(displacements(), "disc.angle")))
    return equal(2 * M * G**2 * DELTA / NATURAL**4, sp.diff(mean(row, THETA), SPEED).subs(SPEED, 0))
