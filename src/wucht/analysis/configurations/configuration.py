"""A steady phase configuration with its name, what is left of the unbalance, and its stability."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.configurations.averaged_stability import AveragedStability, Stability
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.force_balance import members
from wucht.analysis.configurations.state_names import NAMES, name_of, residual_unbalance, type_of
from wucht.analysis.configurations.steady_branches import overlapping
from wucht.analysis.forced import Forced
from wucht.analysis.throw import Throw, steady_throw
from wucht.analysis.vibration import unbalances
from wucht.numerics.angles import wrapped

_SAMPLES = 64  # members of a family
STABLE, STABLE_SLOW, UNSTABLE, UNSTABLE_SLOW, UNDECIDED = (
    "stable", "stable in the averaged equations only", "unstable", "unstable in the averaged equations only", "undecided",
)  # fmt: skip
_BEYOND = "no torque is left from here on: all greater speeds are as good, and this is the one that is reached"


@dataclass(frozen=True)
class Configuration:
    """A state, described and judged. phases: by body, as in the contract.

    share: of the rotor's unbalance that is left. stable_share: of the family. overlapping: bodies of one track are in each
    other's place. throw: of the carrier. disagreement: why the slow and the full equations disagree.
    """

    state: State
    name: str | None
    type: str | None
    speed: float
    phases: dict[str, float]
    residual: float | None
    share: float | None
    amplitude: float
    overlapping: bool
    slow: Stability
    full: Stability
    stable_share: float | None
    throw: Throw | None
    disagreement: str | None = None

    @property
    def verdict(self) -> str:
        """From the full equations, or from the slow ones alone where those do not decide."""
        if self.full.stable is not None:
            return STABLE if self.full.stable else UNSTABLE
        return UNDECIDED if self.slow.stable is None else STABLE_SLOW if self.slow.stable else UNSTABLE_SLOW

    @property
    def why(self) -> str | None:
        """Why the equations disagree, or one of them does not decide, and what is to be known beside."""
        reasons = (_BEYOND if self.state.indifferent else "", self.disagreement or self.slow.reason or self.full.reason)
        return "; ".join(r for r in reasons if r) or None

    @property
    def rank(self) -> tuple[int, float, float]:
        """By which configurations are sorted: those that compensate first, then by what is left."""
        return (*NAMES, None).index(self.name), -1.0 if self.residual is None else self.residual, self.speed


class Describer:
    """Describes the states of a machine's averaged equations, without the full ones.

    own: unbalances (n,) in the order of the torques; order: place of each body of the machine among these.
    """

    def __init__(self, slow: AveragedStability) -> None:
        self.slow, self.torques, self.machine = slow, slow.torques, slow.torques.machine
        self.order = [self.torques.names.index(b.name) for b in self.machine.bodies]
        self.own = unbalances(self.machine)[np.argsort(self.order)]
        self.forced = Forced.of(self.machine, np.zeros(len(self.order)))

    def described(self, state: State, full: Stability) -> Configuration:
        """The configuration of a state. full: what is known from the full equations."""
        t, (slow, share) = self.torques, self._stability(state)
        left = residual_unbalance(t, self.own, state.phases)
        name = name_of(t, state, left)
        forced = replace(self.forced, placed=state.phases[self.order])
        return Configuration(
            state=state, slow=slow, full=full, stable_share=share, name=name,
            type=type_of(t, name),
            speed=float(t.senses[0]) * state.speed, phases=self._phases(state), residual=left,
            share=float(left / abs(self.own[0])) if left is not None and self.own[0] else None,
            amplitude=float(forced.amplitude(np.array([state.speed]))[0][0]), overlapping=overlapping(t, state.phases),
            throw=steady_throw(self.machine, forced, state.speed),
        )  # fmt: skip

    def _stability(self, state: State) -> tuple[Stability, float | None]:
        """From the averaged equations; of a family, as far as members agree, and the share of the stable ones."""
        stability = self.slow.stability(state)
        if not state.dimension:
            return stability, None
        at = np.concatenate([state.phases[:, None], members(self.torques, _SAMPLES)], axis=1)
        share = float((self.slow.exponents(state, at)[:, 0].real < 0).mean())
        if 0 < share < 1 and stability.stable is not None:
            return Stability(None, stability.exponents, f"stable on {100 * share:.0f} % of the family"), share
        return stability, share

    def _phases(self, state: State) -> dict[str, float]:
        """Of a balancing body: its angle less that of its rotor, counter-clockwise.

        Of another rotor: its angle less that of the main one, each in its own sense.
        """
        t, phases = self.torques, state.phases
        return {
            b.name: float(wrapped(phases[i] if b.about is None else (phases[i] - phases[t.heads[i]]) * t.senses[i]))
            for b, i in zip(self.machine.bodies, self.order, strict=True)
            if i
        }
