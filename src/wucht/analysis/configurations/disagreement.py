"""Why the slow and the full equations disagree on the stability of a steady phase configuration."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.analysis.averaged import slow_machine
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.slow_stability import SlowStability, Stability
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.vibration import Vibration
from wucht.errors import WuchtError
from wucht.machines.machine import Machine

_NEXT_ORDER = 5  # bodies: with more it takes a minute to write the slow equations of the next order
_OWN = 0.05  # relative: a multiplier's frequency this near to that of the carrier's vibration belongs to it


@dataclass(frozen=True)
class Disagreement:
    """Of a machine's slow equations, with or without inertia, and its full ones."""

    machine: Machine
    torques: SteadyTorques
    inertia: bool

    @cached_property
    def _poles(self) -> np.ndarray:
        return Vibration.of(self.machine).poles

    @cached_property
    def _second_order(self) -> SlowStability | None:
        if len(self.machine.bodies) > _NEXT_ORDER:
            return None
        try:
            return SlowStability(self.torques, slow_machine(self.machine, self.inertia, 2))
        except WuchtError:
            return None

    def _of_second_order(self, state: State) -> Stability | None:
        """Stability from the slow equations of the next order, None where they are not to be had."""
        try:
            return self._second_order.of_system(state) if self._second_order is not None else None
        except WuchtError:
            return None

    def why(self, state: State, slow: Stability, full: Stability) -> str | None:
        """A sentence, None where they agree or one of them is undecided."""
        if full.stable is None or slow.stable is None or full.stable == slow.stable or full.leading is None:
            return None
        rate, frequency, unit = full.leading.real, abs(full.leading.imag), self.machine.units.speed
        of_time = "1/s" if unit else "a unit of time"
        if full.stable:
            exact = f"in the full equations all perturbations decay (the slowest with {-rate:.3g} {of_time})"
        else:
            pair = frequency > 1e-6 * state.speed
            what = f"a pair of multipliers{self._whose(state.speed, frequency)}" if pair else "a real multiplier"
            exact = f"{what} leaves the unit circle (growth {rate:.3g} {of_time})"
        next_order = self._of_second_order(state)
        if next_order is not None and next_order.stable == full.stable:
            return f"{exact}: the slow equations take the carrier's vibration as steady; those of second order agree"
        moving, slowest = float(np.abs(slow.exponents).max(initial=0.0)), float(-self._poles.real.max())
        decay = (
            f"decay with no more than {slowest:.3g} {of_time}" if slowest > 0
            else "are not damped by anything outside the rotor"
        )  # fmt: skip
        return (
            f"{exact}: the slow equations take the carrier's vibration as steady, but its own transients {decay}, while the "
            f"phases move with up to {moving:.3g} {of_time}"
        )

    def _whose(self, speed: float, frequency: float) -> str:
        """Whose multipliers they are: once a turn a frequency of the carrier is seen less whole multiples of the speed."""
        unit, own = self.machine.units.speed, np.abs(self._poles.imag)
        seen = np.abs(own - speed * np.round(own / speed))
        nearest = int(np.abs(seen - frequency).argmin())
        if abs(seen[nearest] - frequency) < _OWN * own[nearest]:
            return f", those of the carrier's own vibration at about {own[nearest]:.4g} {unit}".rstrip() + ","
        return f" with the frequency {frequency:.4g} {unit}".rstrip()
