"""What a steady phase configuration is called, by what it leaves of the unbalance and by which bodies are in line."""

from __future__ import annotations

import math

import numpy as np

from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.torques import SteadyTorques

NAMES = ("compensating", "together", "opposed")
TYPES: dict[str | None, str] = dict(zip(NAMES, ("I", "II", "III"), strict=True))  # of 002, section 5.1
_NOTHING_LEFT = 1e-9  # of all unbalances: what is left where they compensate
_IN_LINE = math.cos(math.pi / 4)  # two bodies further than that from one direction have no name
_NEAR = 2 * math.sin(math.pi / 8)  # the chord of the same angle: several rotors within it are together


def residual_unbalance(torques: SteadyTorques, own: np.ndarray, phases: np.ndarray) -> float | None:
    """The unbalance that is left of the bodies' own (n,) in phases (n,); None where bodies are not on one axis."""
    if not torques.in_line:
        return None
    left = float(abs((own * np.exp(1j * phases)).sum()))
    return left if left > _NOTHING_LEFT * np.abs(own).sum() else 0.0


def name_of(torques: SteadyTorques, state: State, residual: float | None) -> str | None:
    """What a state is called, one of ``NAMES``, None where it has no name. residual: the unbalance that it leaves."""
    t = torques
    if residual == 0.0 and (t.size > 2 or t.heads[-1] == 0):  # two exciters that cancel each other are opposed
        return "compensating"
    if len(state.beside) > 1:
        return "together" if len(set(state.beside)) == 1 else "opposed"
    if t.size == 2 and (t.coefficients is not None or bool((t.senses == t.senses[0]).all())):
        cosine = math.cos(state.phases[1])
        return ("together" if cosine > 0 else "opposed") if abs(cosine) > _IN_LINE else None
    apart = np.abs(np.exp(1j * state.phases)[:, None] - np.exp(1j * state.phases))
    return "together" if t.in_line and apart.max() <= _NEAR else None


def type_of(torques: SteadyTorques, name: str | None) -> str | None:
    """The type of 002, section 5.1, of a state of this name: of a rotor with two equal balancing bodies."""
    return TYPES.get(name) if torques.in_line and torques.size == 3 and len(torques.classes) == 1 else None
