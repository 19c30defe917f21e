"""Plan -> findings: the law's derivatives, their largest values, its harmonics, and how each restriction is met."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wucht.cams.laws.synthesis import Cap, Restriction
from wucht.cams.tables.motion_law import MotionLaw
from wucht.dynamics.work import Work
from wucht.numerics.harmonics import Harmonics
from wucht.studies.cam_law.prepare import Plan


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
    motion = plan.motion
    angles = np.linspace(0, 2 * np.pi, plan.points + 1)
    derivatives = np.array([motion.law(angles, order) for order in range(4)])
    whole = motion.harmonics()
    harmonics = Harmonics(whole.mean, whole.cosine[: plan.orders], whole.sine[: plan.orders])
    least, greatest = motion.bounds(0)
    peaks = np.array([max(-least, greatest), *(motion.peak(order) for order in (1, 2, 3))])
    met = np.array([_met(r, motion, harmonics) for r in motion.restrictions]).reshape(-1, 2)
    yield Findings(angles, derivatives, harmonics, least, greatest, peaks, met, motion.jump, motion.rise)


def _met(restriction: Restriction, motion: MotionLaw, harmonics: Harmonics) -> tuple[float, float]:
    """The least and the greatest value of what is restricted."""
    if isinstance(restriction, Cap):
        return 0.0, float(harmonics.amplitudes[restriction.harmonic - 1])
    return motion.extremes(restriction)
