"""The constant phase configurations of a machine: found, named, and judged."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.errors import InputError
from wucht.machines.contact import arranged
from wucht.machines.forced import Forced
from wucht.machines.machine import Machine
from wucht.machines.slow import SlowMachine, slow_machine
from wucht.machines.synchronous.closed import State, at_speed, has_closed_form, over_speeds
from wucht.machines.synchronous.polygon import members
from wucht.machines.synchronous.search import by_subdivision, search, speeds_in_line, speeds_said
from wucht.machines.synchronous.torques import SteadyTorques
from wucht.machines.vibration import unbalances
from wucht.results.conventions import wrapped
from wucht.studies.synchronous_states.speeds import SpeedRange
from wucht.studies.synchronous_states.stability import (
    FullEquations,
    Judgement,
    slow_exponents,
    slow_judgement,
    why_they_differ,
)
from wucht.studies.torque_balance.result import Balance

MOST_FULL = 64  # states whose multipliers are computed
NAMES = ("compensating", "together", "opposed")
_TYPES = dict(zip(NAMES, ("I", "II", "III"), strict=True))  # of 002, section 5.1
_NOTHING_LEFT = 1e-9  # of all unbalances: what is left where they compensate
_SAMPLES, _FULL_SAMPLES, _POINTS = 64, 7, 1200  # members of a family, and speeds
_PATTERNS = 64  # ways to be in line for which the speeds are proved complete
_EQUAL_SPEEDS = 1e-6
_IN_LINE = math.cos(math.pi / 4)  # two bodies further than that from one direction have no name
_NEAR = 2 * math.sin(math.pi / 8)  # the chord of the same angle: several rotors within it are together
STABLE, STABLE_SLOW, UNSTABLE, UNSTABLE_SLOW, UNDECIDED = (
    "stable", "stable in the slow equations only", "unstable", "unstable in the slow equations only", "undecided",
)  # fmt: skip
_TOO_MANY = f"multipliers are computed of {MOST_FULL} states at most"
_BEYOND = "no torque is left from here on: all greater speeds are as good, and this is the one that is reached"


@dataclass(frozen=True)
class Judged:
    """A state with its name, what is left of the unbalance, and its stability. phases: by body, as in the contract.

    share: of the rotor's unbalance that is left. stable_share: of the family. overlapping: bodies of one track are in each
    other's place. why: the slow and the full equations disagree, or one of them cannot tell, or what is to be known beside.
    """

    state: State
    name: str | None
    type: str | None
    speed: float
    phases: dict[str, float]
    residual: float | None
    share: float | None
    amplitude: float
    slow: Judgement
    full: Judgement
    stable_share: float | None
    overlapping: bool
    why: str | None

    @property
    def verdict(self) -> str:
        """What the full equations say, or the slow ones alone where those do not tell."""
        if self.full.stable is not None:
            return STABLE if self.full.stable else UNSTABLE
        return UNDECIDED if self.slow.stable is None else STABLE_SLOW if self.slow.stable else UNSTABLE_SLOW


def prepared(machine: Machine, speed: float | None) -> Machine:
    """The machine with its schedules done, all bodies released, and the main rotor at a given speed (signed)."""
    steady = replace(machine.at(machine.corners[-1]), schedules=())
    bodies = [replace(b, release=None) for b in steady.bodies]
    if speed is not None:
        main = next(i for i, b in enumerate(bodies) if b.name == machine.rotor.name)
        bodies[main] = replace(bodies[main], coordinate=replace(bodies[main].coordinate, prescribed=sp.Float(speed)))
    return replace(steady, bodies=tuple(bodies))


@dataclass(frozen=True)
class Configurations:
    """What is asked of a prepared machine. speeds: those that are searched where the drive decides the speed."""

    machine: Machine
    speeds: SpeedRange
    inertia: bool
    full: bool
    report: Callable[[float, float], None] = field(default=lambda done, whole: None)

    @cached_property
    def slow(self) -> SlowMachine:
        """The slow equations."""
        return slow_machine(self.machine, self.inertia)

    @cached_property
    def torques(self) -> SteadyTorques:
        """The mean torques."""
        return SteadyTorques.from_slow(self.slow)

    @cached_property
    def in_line(self) -> bool:
        """Whether all bodies are on one axis and only the vibration places them: then names and residual have a meaning."""
        return self.torques.coefficients is not None and bool((self.torques.senses == self.torques.senses[0]).all())

    @cached_property
    def _grid(self) -> np.ndarray:
        sense, s = self.torques.senses[0], self.speeds
        low, high = sorted((sense * s.low, sense * s.high))
        grid = Balance(self.machine, self.machine.rotor, np.zeros(self.torques.size), (low, high), _POINTS).grid
        found: np.ndarray = np.sort(sense * grid)
        return found

    @cached_property
    def found(self) -> tuple[list[State], bool, str]:
        """The states, each verified, whether they are all, and how that was shown or why not."""
        states, complete, shown = self._searched()
        verified = [s for s in states if self.torques.balanced(s.speed, s.phases)]
        if len(verified) < len(states):
            complete, shown = False, f"{shown}; {len(states) - len(verified)} more do not fulfil the balance of the torques"
        if self.speeds.chosen:
            here = "these are all in this range, but its" if complete else "the"
            shown += (
                f"; {here} upper end is the program's choice, as the drive runs away without load: study.range sets another"
            )
        return verified, complete and not self.speeds.chosen, shown

    def _searched(self) -> tuple[list[State], bool, str]:
        t, low, high = self.torques, self.speeds.low, self.speeds.high
        at = np.array([t.given]) if t.given is not None else np.linspace(low, high, 50)
        if not has_closed_form(t, at):
            searched = search(t, low, high)
            return searched.states, searched.complete, searched.shown
        if t.given is not None:
            return at_speed(t, t.given), True, "closed form: other phases than these do not stay"
        return self._driven()

    def _driven(self) -> tuple[list[State], bool, str]:
        """In closed form over the speed; the speeds compared with those that subdivision finds."""
        t, low, high = self.torques, self.speeds.low, self.speeds.high
        states: list[State] = []
        for a, b in t.parts(low, high):
            states += over_speeds(t, np.unique([a, *self._grid[(self._grid > a) & (self._grid < b)], b]))
        found = sorted(s.speed for s in states if s.beside or t.size == 2)
        if t.size == 2:
            searched = by_subdivision(t, low, high)
            shown = sorted(s.speed for s in searched.states) if searched.complete else None
        else:
            several = len(t.classes) and math.prod(len(m) + 1 for m in t.classes) <= _PATTERNS
            each = speeds_in_line(t, low, high) if several else None
            shown = None if each is None else sorted(w for speeds in each for w in speeds)
        where = speeds_said(t, low, high)
        if shown is None or len(shown) != len(found) or not np.allclose(shown, found, rtol=_EQUAL_SPEEDS):
            return states, False, f"phases in closed form; {where} on a grid: it is not shown that no state is missing"
        return states, True, f"phases in closed form; {where} by subdivision with bounds on the Jacobian"

    @cached_property
    def judged(self) -> list[Judged]:
        """All states, those that compensate first, then by what is left."""
        states, names = self.found[0], list(self.torques.names)
        order = [names.index(b.name) for b in self.machine.bodies]
        own = unbalances(self.machine)[np.argsort(order)]
        forced = Forced.of(self.machine, np.zeros(len(names)))
        full = FullEquations.of(self.machine, self.torques) if self.full else None
        found = []
        for k, state in enumerate(states):
            self.report(k, len(states))
            chosen = full if k < MOST_FULL else None
            found.append(self._judge(state, own, replace(forced, phases=state.phases[order]), chosen))
        self.report(len(states), len(states))
        rank = {name: k for k, name in enumerate((*NAMES, None))}
        return sorted(found, key=lambda j: (rank[j.name], -1.0 if j.residual is None else j.residual, j.speed))

    def _judge(self, state: State, own: np.ndarray, forced: Forced, full: FullEquations | None) -> Judged:
        t = self.torques
        residual = abs((own * np.exp(1j * state.phases)).sum()) if self.in_line else None
        if residual is not None and residual <= _NOTHING_LEFT * np.abs(own).sum():
            residual = 0.0
        slow = slow_judgement(t, self.slow, state)
        share = None
        if state.dimension:
            slow, share = self._of_family(state, slow)
        exact = Judgement(None, np.empty(0, complex), "the multipliers were not asked for" if not self.full else _TOO_MANY)
        if full is not None:
            exact = full.judgement(state) if not state.dimension else self._full_of_family(full, state)
        name = self.name(state, residual)
        unit = self.machine.units.speed
        differ = why_they_differ(self.machine, state, slow, exact, self.inertia, unit)
        why = [_BEYOND if state.indifferent else "", differ or slow.reason or exact.reason]
        return Judged(
            state=state,
            name=name,
            type=_TYPES[name] if name is not None and self._pair() else None,
            speed=float(t.senses[0]) * state.speed,
            phases=self.phases(state),
            residual=None if residual is None else float(residual),
            share=float(residual / abs(own[0])) if residual is not None and own[0] else None,
            amplitude=float(forced.amplitude(np.array([state.speed]))[0][0]),
            slow=slow,
            full=exact,
            stable_share=share,
            overlapping=self._overlapping(state),
            why="; ".join(w for w in why if w) or None,
        )

    def _of_family(self, state: State, one: Judgement) -> tuple[Judgement, float]:
        """Stability of the whole family transverse to it, from some of its members."""
        at = np.concatenate([state.phases[:, None], members(self.torques, _SAMPLES)], axis=1)
        largest = slow_exponents(self.torques, self.slow, state, at)[:, 0].real
        share = float((largest < 0).mean())
        if 0 < share < 1 and one.stable is not None:
            reason = f"stable on {100 * share:.0f} % of the family"
            return Judgement(None, one.exponents, reason), share
        return one, share

    def _full_of_family(self, full: FullEquations, state: State) -> Judgement:
        """The same from the full equations: their multipliers differ along the family."""
        one, at = full.judgement(state), members(self.torques, _FULL_SAMPLES)
        all_ = [one, *(full.judgement(replace(state, phases=phases)) for phases in at.T)]
        decided = [j.stable for j in all_ if j.stable is not None]
        if one.stable is None or len(set(decided)) < 2:
            return one
        here = "stable" if one.stable else "not stable"
        reason = f"stable at {sum(decided)} of {len(decided)} members of the family that were looked at, {here} at this one"
        return Judgement(None, one.exponents, reason)

    def _pair(self) -> bool:
        t = self.torques
        return self.in_line and t.size == 3 and len(t.classes) == 1

    def name(self, state: State, residual: float | None) -> str | None:
        """What the state is called, None where it has no name."""
        t = self.torques
        if residual == 0.0 and (t.size > 2 or t.heads[-1] == 0):  # two exciters that cancel each other are opposed
            return "compensating"
        if len(state.beside) > 1:
            return "together" if len(set(state.beside)) == 1 else "opposed"
        alike = t.coefficients is not None
        if t.size == 2 and (alike or bool((t.senses == t.senses[0]).all())):
            cosine = math.cos(state.phases[1])
            return ("together" if cosine > 0 else "opposed") if abs(cosine) > _IN_LINE else None
        apart = np.abs(np.exp(1j * state.phases)[:, None] - np.exp(1j * state.phases))
        return "together" if self.in_line and apart.max() <= _NEAR else None

    def phases(self, state: State) -> dict[str, float]:
        """Of a balancing body: its angle less that of its rotor, counter-clockwise.

        Of another rotor: its angle less that of the main one, each in its own sense.
        """
        t, found = self.torques, {}
        for b in self.machine.bodies:
            i = t.names.index(b.name)
            if i == 0:
                continue
            turn = state.phases[i] - state.phases[t.heads[i]] if b.about is not None else state.phases[i]
            found[b.name] = float(wrapped(turn * (t.senses[i] if b.about is not None else 1.0)))
        return found

    def _overlapping(self, state: State) -> bool:
        t = self.torques
        if not self.machine.tracks:
            return False
        angles = {name: float(s * a) for name, s, a in zip(t.names, t.senses, state.phases, strict=True)}
        try:
            arranged(self.machine, angles)
        except InputError:
            return True
        return False
