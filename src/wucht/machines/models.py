"""The dimensionless machines of the dissertation: O. Drozdetskaya 2020 (source 002), with the parameters printed there.

They are stated by energies like every machine. With xi = x M*/(m r), tau = k t, the equation of phi is multiplied by
s/(epsilon w) and those of theta_i by 1/mu; then (4.11)-(4.20) follow from

    T = (xi'^2 + eta'^2)/2 + s phi' n(phi) + s phi'^2/(2 epsilon w) + sum(theta_i' n(theta_i) + theta_i'^2/(2 mu)),
    n(a) = -xi' sin a + eta' cos a,   V = (xi^2 + eta^2)/2,   R = sigma (xi'^2 + eta'^2).

The printed damper torques beta_p (phi' - theta_i') on the pendulums and beta_r on the rotor are each other's reaction only if
mu s beta_r = 2 epsilon w beta_p (errata); so they are applied forces here, each booked separately.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import sympy as sp

from wucht.machines.parts import part_kinds
from wucht.machines.parts.base import SI, Frame, Part, Point, si
from wucht.mechanics.energies import AppliedForce, Energies
from wucht.mechanics.lagrange import Coordinate

ModelBodies = tuple[tuple[str, str, str | None], ...]  # name, kind, about which it turns


class DimensionlessMachine(Part):
    """A dimensionless machine as one part: its parameters have bare names (``u``), its bodies are named as in SI machines."""

    equations: ClassVar[str] = ""
    bodies: ClassVar[ModelBodies] = (("rotor", "rotor", None),)
    directions: ClassVar[str] = "xy"

    @property
    def path(self) -> str:
        """Empty: parameters are addressed by their bare names."""
        return ""

    def coordinates(self) -> tuple[Coordinate, ...]:
        """The carrier's coordinates."""
        return tuple(Coordinate.from_names(f"carrier.{d}", f"carrier.v{d}") for d in self.directions)

    def reference_frame(self) -> Frame:
        """Return the frame: all bodies turn about the carrier's centre."""
        turning = {n: Coordinate.from_names(f"{n}.angle", f"{n}.speed", angle=True) for n, _, _ in self.bodies}
        centre = Point.from_coordinates(dict(zip(self.directions, self.coordinates(), strict=True)))
        return Frame(centre=centre, bodies=turning, axes=dict.fromkeys(turning, centre))

    def arms(self) -> Mapping[str, sp.Expr]:
        """Lengths are in units of the rotor's eccentricity."""
        return {self.bodies[0][0]: sp.S.One}

    def support(self, frame: Frame) -> Energies:
        """V = xi^2/2, R = sigma xi'^2: spring and damper of the carrier."""
        at, sigma = frame.centre, self.symbol("sigma")
        return Energies(potential=(at.x**2 + at.y**2) / 2, dissipation=sigma * (at.vx**2 + at.vy**2))

    def warnings(self) -> tuple[str, ...]:
        """Return warnings about the parameters."""
        return ()

    def mismatch(self, frame: Frame) -> sp.Expr | None:
        """Return the power by which dampers violate action = reaction, None where they cannot."""
        return None


def _excess(frame: Frame, body: str) -> sp.Expr:
    """n(a): the velocity of the axis along the body's direction of motion."""
    a = frame.angle(body)
    return -frame.centre.vx * sp.sin(a) + frame.centre.vy * sp.cos(a)


class RotorOnCarrier(DimensionlessMachine):
    """An unbalanced rotor on a carrier that moves in x. Drozdetskaya (3.33)-(3.34)."""

    kind = "rotor-on-carrier"
    equations = "Drozdetskaya (3.33)-(3.34)"
    directions = "x"

    epsilon: SI[float] = si("", "unbalance over inertia, M e^2/J", "epsilon", gt=0)
    sigma: SI[float] = si("", "damping of the support, b/(2 M k)", "sigma", ge=0)
    speed_ratio: SI[float] = si("", "no-load speed over natural frequency", "lambda", alias="lambda")
    u: SI[float] = si("", "slope of the motor, U_M/(k M e^2)", "u", ge=0)

    def energies(self, frame: Frame) -> Energies:
        """T = xi'^2/2 + phi' n(phi) + phi'^2/(2 epsilon); motor u (lambda - phi')."""
        epsilon, no_load, u = self.symbols("epsilon", "lambda", "u")
        at, w = frame.centre, frame.speed("rotor")
        return Energies(
            kinetic=(at.vx**2 + at.vy**2) / 2 + w * _excess(frame, "rotor") + w**2 / (2 * epsilon),
            applied_forces=(AppliedForce(u * (no_load - w), w, "drive"),),
        )


class LavalRotor(RotorOnCarrier):
    """An unbalanced rotor on a carrier that moves in x and y. Drozdetskaya (3.59)-(3.61)."""

    kind = "laval-rotor"
    equations = "Drozdetskaya (3.59)-(3.61)"
    directions = "xy"


class SelfBalancingRotor(DimensionlessMachine):
    """An unbalanced rotor with two balancing pendulums. Drozdetskaya (4.11)-(4.20).

    In (4.8) the 2 of M* = M + 2 m and of beta_r = 2 b_r/(k J_R) is the number n of pendulums.
    """

    kind = "self-balancing-rotor"
    equations = "Drozdetskaya (4.11)-(4.20)"
    bodies: ClassVar[ModelBodies] = (("rotor", "rotor", None), ("p1", "pendulum", "rotor"), ("p2", "pendulum", "rotor"))

    epsilon: SI[float] = si("", "unbalance over inertia, M e^2/J_R", "epsilon", gt=0)
    mu: SI[float] = si("", "pendulum mass ratio, p m/M*", "mu", gt=0)
    s: SI[float] = si("", "unbalance ratio, M e/(m r)", "s", gt=0)
    w: SI[float] = si("", "amplitude ratio, m r/(M* e)", "w", gt=0)
    beta_p: SI[float] = si("", "damping of the pendulums, b_r/(k J_P)", "beta_p", ge=0)
    beta_r: SI[float] = si("", "damping of n pendulums on the rotor, n b_r/(k J_R)", "beta_r", ge=0)
    speed_ratio: SI[float] = si("", "no-load speed over natural frequency", "lambda", alias="lambda")
    sigma: SI[float] = si("", "damping of the support, b/(2 k M*)", "sigma", ge=0)
    u: SI[float] = si("", "slope of the motor, U_M/(k M e^2)", "u", ge=0)

    def energies(self, frame: Frame) -> Energies:
        """See the head of this file."""
        epsilon, mu, s, w, beta_p, no_load, u = self.symbols("epsilon", "mu", "s", "w", "beta_p", "lambda", "u")
        at, phi_ = frame.centre, frame.speed("rotor")
        kinetic = (at.vx**2 + at.vy**2) / 2 + s * phi_ * _excess(frame, "rotor") + s * phi_**2 / (2 * epsilon * w)
        kinetic += sp.Add(*(_excess(frame, n) * frame.speed(n) + frame.speed(n) ** 2 / (2 * mu) for n in self._pendulums))
        speeds = [frame.speed(n) for n in self._pendulums]
        on_pendulums = (AppliedForce(beta_p / mu * (phi_ - t), t, energy_side="lost") for t in speeds)
        on_rotor = self._coupling() * sp.Add(*(t - phi_ for t in speeds))
        motor = AppliedForce(s * u / w * (no_load - phi_), phi_, "drive")
        return Energies(kinetic, applied_forces=(motor, *on_pendulums, AppliedForce(on_rotor, phi_, energy_side="lost")))

    @property
    def _pendulums(self) -> list[str]:
        return [name for name, _, about in self.bodies if about]

    def _coupling(self) -> sp.Expr:
        s, beta_r, epsilon, w = self.symbols("s", "beta_r", "epsilon", "w")
        return s * beta_r / (len(self._pendulums) * epsilon * w)

    def arms(self) -> Mapping[str, sp.Expr]:
        """Lengths are in units of m r/M*, and w = m r/(M* e)."""
        return {"rotor": 1 / self.symbol("w")}

    def mismatch(self, frame: Frame) -> sp.Expr:
        """(s beta_r/(n epsilon w) - beta_p/mu) sum (theta_i' - phi') phi': power without a source."""
        mu, beta_p = self.symbols("mu", "beta_p")
        phi_ = frame.speed("rotor")
        return (self._coupling() - beta_p / mu) * sp.Add(*(frame.speed(n) - phi_ for n in self._pendulums)) * phi_

    def warnings(self) -> tuple[str, ...]:
        """The parameters may violate the identities that follow from their definitions (4.8)."""
        verdict, sentences = "no machine has these parameters", []
        n = len(self._pendulums)
        reaction, factor = n * self.epsilon * self.w * self.beta_p, "" if n == 1 else f"{n} "
        right = reaction / (self.mu * self.s)
        if abs(self.beta_r - right) > 1e-6 * right:
            sides = f"mu s beta_r = {self.mu * self.s * self.beta_r:.4g}, {factor}epsilon w beta_p = {reaction:.4g}"
            reason = "the dampers' torque on the rotor is not the reaction of that on the pendulums"
            sentences.append(f"{verdict}: {reason} ({sides}); beta_r = {right:.6g} would be right")
        rest = 1 - self.s * self.w
        if rest <= 0 or n * self.mu / rest > 1 + 1e-9:
            p = f"{n * self.mu / rest:.4g}" if rest > 0 else "none"
            sentences.append(f"{verdict}: s w = 1 - {factor}mu/p requires p = {p}, but p = m r^2/J_P lies between 0 and 1")
        return tuple(sentences)


class Exciter(SelfBalancingRotor):
    """An unbalanced rotor with one coaxial pendulum, an exciter. Drozdetskaya, section 6.2: (4.11)-(4.20) with n = 1."""

    kind = "exciter"
    equations = "Drozdetskaya (4.11)-(4.20) with one pendulum"
    bodies = SelfBalancingRotor.bodies[:2]


def models() -> dict[str, type[DimensionlessMachine]]:
    """Return the dimensionless machines by name, of wucht and of the user's packages."""
    return part_kinds(DimensionlessMachine)
