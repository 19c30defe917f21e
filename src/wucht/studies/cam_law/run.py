"""Plan -> findings: the law's derivatives, their largest values, its harmonics, and how each restriction is met."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wucht.cams.laws.law import Law
from wucht.cams.laws.rise_and_return import RiseAndReturn
from wucht.cams.laws.synthesis import Cap, Restriction, extremes
from wucht.dynamics.work import Work
from wucht.numerics.harmonics import Harmonics, even_angles
from wucht.numerics.valleys import valleys
from wucht.studies.cam_law.prepare import Plan

_SAMPLES = 4096  # of a law that has no end of harmonics
_FINE = 2000  # of an arc, on which the values of such a law are looked at


@dataclass(frozen=True, eq=False)
class Findings:
    """angles (N,). derivatives (4, N): of orders 0 to 3. harmonics: of the motion. least, greatest: of the motion. peaks (4,):
    the largest magnitude of each derivative. met: of each restriction the least and the greatest value (R, 2). jump: the
    largest of the acceleration; rise (3,): Cv, Ca and Cj of a standard law, None of others."""

    angles: np.ndarray
    derivatives: np.ndarray
    harmonics: Harmonics
    least: float
    greatest: float
    peaks: np.ndarray
    met: np.ndarray
    jump: float
    rise: np.ndarray | None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """All at once: it takes milliseconds."""
    work.report(0.0, "motion law")
    law = plan.motion.law
    angles = np.linspace(0, 2 * np.pi, plan.points + 1)
    derivatives = np.array([law(angles, order) for order in range(4)])
    whole = law if isinstance(law, Harmonics) else Harmonics.sampled(law(even_angles(_SAMPLES)))
    harmonics = Harmonics(whole.mean, whole.cosine[: plan.orders], whole.sine[: plan.orders])
    least, greatest = _bounds(law, 0)
    peaks = np.array([max(-least, greatest), *(_peak(law, order) for order in (1, 2, 3))])
    met = np.array([_met(r, law, harmonics) for r in plan.motion.restrictions]).reshape(-1, 2)
    jump, rise = (law.jump, np.array([law.law.Cv, law.law.Ca, law.law.Cj])) if isinstance(law, RiseAndReturn) else (0.0, None)
    yield Findings(angles, derivatives, harmonics, least, greatest, peaks, met, jump, rise)


def _bounds(law: Law, order: int) -> tuple[float, float]:
    """The least and the greatest value of a derivative, between the angles that are looked at too."""
    if isinstance(law, Harmonics):
        return law.derivative(order).bounds
    lowest, highest = valleys(lambda phi: law(phi, order))[1], valleys(lambda phi: -law(phi, order))[1]
    return float(lowest.min()), float(-highest.min())


def _peak(law: Law, order: int) -> float:
    if isinstance(law, RiseAndReturn):
        return law.largest(order)
    least, greatest = _bounds(law, order)
    return max(-least, greatest)


def _met(restriction: Restriction, law: Law, harmonics: Harmonics) -> tuple[float, float]:
    """The least and the greatest value of what is restricted."""
    if isinstance(restriction, Cap):
        return 0.0, float(harmonics.amplitudes[restriction.harmonic - 1])
    if isinstance(law, Harmonics):
        return extremes(restriction, law)
    at = np.linspace(restriction.begin, restriction.end, _FINE if restriction.end > restriction.begin else 1)
    values = law(at, restriction.order)
    return float(values.min()), float(values.max())
