"""Plan of a design."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.dynamics.exciters.design_trials import DesignTrials
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.machines.machine import Machine
from wucht.studies.exciter_design.spec import ExciterDesign


@dataclass(frozen=True)
class Plan:
    """Plan of a design.

    numbers: nominal values of the variables (k,). target: cycles of the target. signal, unit: of the counted signal.
    generations: of the search. warnings: doubts about the study.
    """

    spec: ExciterDesign
    machine: Machine
    trials: DesignTrials
    numbers: np.ndarray
    target: LoadCycles
    signal: str
    unit: str
    generations: int
    warnings: tuple[str, ...]
