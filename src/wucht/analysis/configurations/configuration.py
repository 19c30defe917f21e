"""A steady phase configuration: its name, its residual unbalance, and its stability; and all in which a machine can run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.averaged_equations import averaged_equations_of, keeps_inertia
from wucht.analysis.configurations.averaged_stability import AveragedStability, Stability
from wucht.analysis.configurations.closed_form import State, family_members
from wucht.analysis.configurations.search import CancelCheck, StateSearch, all_states
from wucht.analysis.configurations.steady_branches import overlapping
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.throw import Throw, steady_throw
from wucht.analysis.vibration import ForcedVibration, unbalances
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import MOST_BODIES, driven_speeds, machine_at_speed
from wucht.numerics.angles import wrap_angle, wrap_to_pi

NAMES = ("compensating", "together", "opposed")
TYPES: dict[str | None, str] = dict(zip(NAMES, ("I", "II", "III"), strict=True))  # of 002, section 5.1
_NOTHING_LEFT = 1e-9  # of all unbalances: the residual where they compensate
_IN_LINE = math.cos(math.pi / 4)  # two bodies further from one direction have no name
_NEAR = 2 * math.sin(math.pi / 8)  # the chord of the same angle: several rotors within it are together
_SAMPLES = 64  # members of a family
STABLE, STABLE_SLOW, UNSTABLE, UNSTABLE_SLOW, UNDECIDED = (
    "stable", "stable in the averaged equations only", "unstable", "unstable in the averaged equations only", "undecided",
)  # fmt: skip
_BEYOND = "no torque acts from this speed on: all greater speeds are steady too, and this is the one that is reached"


def residual_unbalance(torques: SteadyTorques, body_unbalances: np.ndarray, phases: np.ndarray) -> float | None:
    """The residual of the bodies' unbalances (n,) at phases (n,); None where bodies are not on one axis."""
    if not torques.is_coaxial:
        return None
    residual = float(abs((body_unbalances * np.exp(1j * phases)).sum()))
    return residual if residual > _NOTHING_LEFT * np.abs(body_unbalances).sum() else 0.0


def name_of(torques: SteadyTorques, state: State, residual: float | None) -> str | None:
    """Name of a state, one of ``NAMES``, None where it has no name. residual: its residual unbalance."""
    t = torques
    if residual == 0.0 and (t.size > 2 or t.heads[-1] == 0):  # two exciters that cancel each other are opposed
        return "compensating"
    if len(state.sides) > 1:
        return "together" if len(set(state.sides)) == 1 else "opposed"
    if t.size == 2 and (t.coefficients is not None or bool((t.senses == t.senses[0]).all())):
        cosine = math.cos(state.phases[1])
        return ("together" if cosine > 0 else "opposed") if abs(cosine) > _IN_LINE else None
    apart = np.abs(np.exp(1j * state.phases)[:, None] - np.exp(1j * state.phases))
    return "together" if t.is_coaxial and apart.max() <= _NEAR else None


def type_of(torques: SteadyTorques, name: str | None) -> str | None:
    """The type of 002, section 5.1, of a state of this name: of a rotor with two equal balancing bodies."""
    return TYPES.get(name) if torques.is_coaxial and torques.size == 3 and len(torques.classes) == 1 else None


@dataclass(frozen=True)
class Configuration:
    """A steady phase configuration with its stability. phases: by body, as in the contract.

    share: residual unbalance over the rotor's. stable_share: of the family. overlapping: bodies of one track are in each
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
        """Verdict of the full equations, or of the slow ones alone where the full ones do not decide."""
        if self.full.stable is not None:
            return STABLE if self.full.stable else UNSTABLE
        return UNDECIDED if self.slow.stable is None else STABLE_SLOW if self.slow.stable else UNSTABLE_SLOW

    @property
    def reason(self) -> str | None:
        """Reason why the equations disagree or one of them does not decide, and remarks."""
        reasons = (_BEYOND if self.state.is_indifferent else "", self.disagreement or self.slow.reason or self.full.reason)
        return "; ".join(r for r in reasons if r) or None

    @property
    def rank(self) -> tuple[int, float, float]:
        """Key by which configurations are sorted: those that compensate first, then by residual unbalance."""
        return (*NAMES, None).index(self.name), -1.0 if self.residual is None else self.residual, self.speed


class ConfigurationDescriber:
    """Describes the states of a machine's averaged equations, without the full ones.

    body_unbalances: (n,) in the order of the torques; order: place of each body of the machine among these.
    """

    def __init__(self, averaged_stability: AveragedStability) -> None:
        self.averaged_stability, self.torques, self.machine = (
            averaged_stability,
            averaged_stability.torques,
            averaged_stability.torques.machine,
        )
        self.order = [self.torques.names.index(b.name) for b in self.machine.bodies]
        self.body_unbalances = unbalances(self.machine)[np.argsort(self.order)]
        self.forced_vibration = ForcedVibration.of(self.machine, np.zeros(len(self.order)))

    def describe(self, state: State, full: Stability) -> Configuration:
        """The configuration of a state. full: its stability in the full equations."""
        t, (slow, share) = self.torques, self._stability(state)
        residual = residual_unbalance(t, self.body_unbalances, state.phases)
        name = name_of(t, state, residual)
        vibration = replace(self.forced_vibration, phase_law=state.phases[self.order])
        return Configuration(
            state=state, slow=slow, full=full, stable_share=share, name=name,
            type=type_of(t, name),
            speed=float(t.senses[0]) * state.speed, phases=self._phases(state), residual=residual,
            share=float(residual / abs(self.body_unbalances[0])) if residual is not None and self.body_unbalances[0] else None,
            amplitude=float(vibration.amplitude(np.array([state.speed]))[0][0]), overlapping=overlapping(t, state.phases),
            throw=steady_throw(self.machine, vibration, state.speed),
        )  # fmt: skip

    def _stability(self, state: State) -> tuple[Stability, float | None]:
        """Stability in the averaged equations; of a family, as far as members agree, and the share of stable members."""
        stability = self.averaged_stability.stability(state)
        if not state.dimension:
            return stability, None
        at = np.concatenate([state.phases[:, None], family_members(self.torques, _SAMPLES)], axis=1)
        share = float((self.averaged_stability.exponents(state, at)[:, 0].real < 0).mean())
        if 0 < share < 1 and stability.stable is not None:
            return Stability(None, stability.exponents, f"stable on {100 * share:.0f} % of the family"), share
        return stability, share

    def _phases(self, state: State) -> dict[str, float]:
        """Phases by body.

        Of a balancing body: its angle minus that of its rotor, counter-clockwise. Of another rotor: its angle minus that of the
        main one, each in its sense.
        """
        t, phases = self.torques, state.phases
        return {
            b.name: float(wrap_angle(phases[i] if b.about is None else (phases[i] - phases[t.heads[i]]) * t.senses[i]))
            for b, i in zip(self.machine.bodies, self.order, strict=True)
            if i
        }


FULL_UNDECIDED = Stability.without_verdict("the full equations are not evaluated")


def _can_run(c: Configuration) -> bool:
    return c.slow.stable is True and not c.overlapping


@dataclass(frozen=True)
class RunningConfigurations:
    """All configurations in which the torques on each body balance, the slowest first, with the search for them."""

    torques: SteadyTorques
    configurations: tuple[Configuration, ...]
    search: StateSearch

    @classmethod
    def of(
        cls, machine: Machine, speeds: tuple[float, float] | None = None, watch: CancelCheck = None
    ) -> RunningConfigurations:
        """The configurations of a machine with its schedules finished and all bodies released.

        Parameters
        ----------
        machine : Machine
        speeds : (float, float), optional
            Lowest and highest speed of the search, in the main rotor's sense; by default those that the drives reach.
        watch : callable, optional
            Called often; an exception from it ends the search.

        Raises
        ------
        InputError
            Where there are no averaged equations, too many bodies, or no drive.
        """
        steady = machine_at_speed(machine, None)
        if len(steady.bodies) > MOST_BODIES:
            requirement = f"there must be at most {MOST_BODIES}, the main rotor included"
            raise InputError("machine.bodies", len(steady.bodies), requirement)
        slow = averaged_equations_of(steady, keeps_inertia(steady, None))
        torques, (low, high) = SteadyTorques.from_averaged_equations(slow), speeds or driven_speeds(steady)[0]
        if torques.fixed_speed is None and not high > 0:
            raise InputError("machine.drive", None, "nothing drives the machine", code="no-drive")
        search = all_states(torques, low, high, watch, prove=False)
        describer = ConfigurationDescriber(AveragedStability(torques, slow))
        configurations = (describer.describe(state, FULL_UNDECIDED) for state in search.states)
        return cls(torques, tuple(sorted(configurations, key=lambda c: abs(c.speed))), search)

    @property
    def stable(self) -> tuple[Configuration, ...]:
        """Those that are stable in the averaged equations, and possible."""
        return tuple(c for c in self.configurations if _can_run(c))

    @property
    def unstable(self) -> tuple[Configuration, ...]:
        """All others."""
        return tuple(c for c in self.configurations if not _can_run(c))

    def nearest(self, phases: Mapping[str, float]) -> Configuration:
        """The stable configuration whose phases are nearest to given ones (rad, by body, as in ``Configuration.phases``).

        Raises ``ValueError`` where none is stable.
        """

        def distance(c: Configuration) -> float:
            return max(abs(float(wrap_to_pi(c.phases[name] - phase))) for name, phase in phases.items())

        return min(self.stable, key=distance)
