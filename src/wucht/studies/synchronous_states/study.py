"""The question of the steady phase configurations of a machine, and their search."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from wucht.analysis.averaged_equations import AveragedEquations, averaged_equations_of, keeps_inertia
from wucht.analysis.configurations.averaged_stability import AveragedStability, Regions, Stability, regions
from wucht.analysis.configurations.closed_form import State, family_members, pattern_count
from wucht.analysis.configurations.configuration import Configuration, ConfigurationDescriber
from wucht.analysis.configurations.full_stability import FullStability
from wucht.analysis.configurations.search import StateSearch, all_states, has_closed_form
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import (
    LOWEST,
    MOST_BODIES,
    computable_speeds,
    driven_speeds,
    machine_at_speed,
    net_torque,
    sense_of,
)
from wucht.schema import SI, Composite, Unit, composite, read_quantity, refuse_unknown, si
from wucht.studies.answer import Answer
from wucht.studies.key_types import Inertia, Interval, TrueOrFalse, Value
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import AVERAGED_EQUATIONS, FULL_EQUATIONS, Study
from wucht.studies.synchronous_states.answer import state_synchronous
from wucht.studies.synchronous_states.figure import figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MOST_CELLS, MOST_FULL = 400, 64  # of an axis of the map; states whose multipliers are computed
_MOST_RATIO = 1e6
_MOST_PATTERNS = 64  # arrangements of bodies in line, of a map
_SAMPLES = 1001
_MEMBERS = 7  # members of a family, besides its representative
_CELLS = 4000  # of a tile of the map
_SEARCH_SHARE, _STABILITY_SHARE = 0.1, 0.8  # shares of the work after the search, and before the map
_NOT_REQUESTED = Stability.without_verdict("the multipliers were not requested")
_TOO_MANY = Stability.without_verdict(f"multipliers are computed for {MOST_FULL} states at most")
_NOT_YET = Stability.without_verdict("its multipliers are not computed yet")
_AXES = {"speed": Unit("rad/s", "speed"), "ratio": Unit("", "ratio")}


def _parse_axes(value: Any) -> Any:
    if not isinstance(value, Mapping):
        raise ValueError("must be a table: axes = { speed = [lo, hi, cells], ratio = [lo, hi, cells] }")
    refuse_unknown(value, _AXES, "study.axes")
    for name in _AXES:
        key, axis = f"study.axes.{name}", value.get(name)
        if not isinstance(axis, list | tuple) or len(axis) != 3:
            raise InputError(key, axis, "must be [lo, hi, cells]", code="shape")
        if isinstance(axis[2], bool) or not isinstance(axis[2], int) or not 2 <= axis[2] <= MOST_CELLS:
            raise InputError(key, axis, f"must be a whole number of cells from 2 to {MOST_CELLS}", code="whole-number")
    return {name: tuple(value[name]) for name in _AXES}


Axes = Annotated[dict[str, tuple[Value, Value, int]], BeforeValidator(_parse_axes)]
Cells = tuple[np.ndarray, np.ndarray]  # the centres of a map's cells: speeds (N,), in the main rotor's sense, and ratios (M,)
# The torques of the machine in synchronous rotation; the lowest and highest speed of the search in the main rotor's sense, None
# where the speed is given; and the map, None without one.
Prepared = tuple[AveragedEquations, SteadyTorques, tuple[float, float] | None, Cells | None]


class SynchronousStates(Study):
    """All steady phase configurations of the balancing bodies or of self-synchronising rotors, with names and stability.

    000 sections 4-6 (tables 1-3), 001 section 2.4 (table 1), 002 section 5.1 (types I, II, III).
    """

    kind = "synchronous-states"
    next_questions = (
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )

    speed: SI[float | None] = si("rad/s", "speed", default=None, help=(
        "speed of the main rotor, signed; by default the one prescribed by its drive, else all at which the drive and the "
        "vibration balance, searched over `range`"
    ))  # fmt: skip
    range: SI[Interval | None] = si("rad/s", "speed", default=None, help=(
        "lowest and highest speed of the search, by default up to the highest speed without vibration, or three times the "
        "highest natural frequency where a drive runs away without load: then the states are not stated to be all"
    ))  # fmt: skip
    inertia: Inertia = Field(default=True, description=(
        "whether averaged equations keep the inertia of balancing bodies; false: strongly damped, Drozdetskaya (4.60)-(4.62)"
    ))  # fmt: skip
    full: TrueOrFalse = Field(default=True, description="whether the multipliers of the full equations are computed too")
    axes: Composite[Axes | None] = composite(default=None, title="axes of a stability map", description=(
        "a stability map over given speeds, {speed = [lo, hi, cells], ratio = [lo, hi, cells]}, cell-centred; ratio: of the "
        "unbalance of all balancing bodies together to that of the rotor, which is changed for it"
    ))  # fmt: skip

    def check(self) -> None:
        """Check that a speed excludes a range of speeds, and that axes begin at 0 or above."""
        if self.speed == 0:
            raise InputError("study.speed", 0.0, "must be a speed other than 0")
        if self.speed is not None and self.range is not None:
            raise InputError("study.range", list(self.range), "not allowed where the speed of the main rotor is given")
        for name, (low, high, _) in self.axes_in(_AXES["speed"].si).items():
            key, axis = f"study.axes.{name}", list((self.axes or {})[name])
            if not low < high:
                raise InputError(key, axis, "must be a pair [low, high] with low below high", code="not-increasing")
            if low < 0:
                raise InputError(key, axis, f"must be a {name} of at least 0", code="negative")
            if name == "ratio" and high > _MOST_RATIO:
                raise InputError(key, axis, f"must be a ratio up to {_MOST_RATIO:g}", code="limits")

    def axes_in(self, speed_unit: str) -> dict[str, tuple[float, float, int]]:
        """Return the axes of the map: lowest, highest, cells; none without a map.

        speed_unit: of the machine, empty if it is dimensionless. Raises ``InputError`` where an axis has another one.
        """
        axes = {}
        for name, (low, high, cells) in (self.axes or {}).items():
            unit, key = Unit(speed_unit if name == "speed" else "", _AXES[name].long_name), f"study.axes.{name}"
            axes[name] = (read_quantity(unit, low, f"{key}[0]"), read_quantity(unit, high, f"{key}[1]"), cells)
        return axes

    def equations(self) -> str:
        """See ``Study``."""
        return f"{AVERAGED_EQUATIONS} for the states, {FULL_EQUATIONS} for their stability" if self.full else AVERAGED_EQUATIONS

    def turning(self) -> str:
        """See ``Study``."""
        return "" if self.speed is None else "the main rotor held at study.speed"

    def prepare(self, machine: Machine) -> Prepared:
        """Return torques, speeds and map. Raises ``InputError`` where a machine has no phases, or no averaged equations."""
        if len(machine.bodies) < 2:
            _refuse_single(machine)
        if len(machine.bodies) > MOST_BODIES:
            allowed = f"there must be at most {MOST_BODIES}, the main rotor included"
            raise InputError("machine.bodies", len(machine.bodies), allowed)
        if self.range is not None and machine.rotor.coordinate.prescribed_velocity is not None:
            reason = "not allowed where the speed of the main rotor is given"
            raise InputError("study.range", list(self.range), reason, code="prescribed")
        steady, unheld = machine_at_speed(machine, self.speed), machine_at_speed(machine, None)
        averaged_equations = averaged_equations_of(steady, keeps_inertia(steady, self.inertia))
        torques, speeds = SteadyTorques.from_averaged_equations(averaged_equations), None
        if torques.fixed_speed is None:
            speeds = self._search_range(steady)
        else:
            self._check_speed(unheld, torques, torques.fixed_speed)
        has_closed_form(torques, *speeds or (0.0, 0.0))
        return averaged_equations, torques, speeds, self._map(unheld, torques)

    def _check_speed(self, unheld: Machine, torques: SteadyTorques, speed: float) -> None:
        """Refuse a given speed at which nothing can be computed. Raises ``InputError``."""
        if speed <= 0:
            reason = "the main rotor does not turn: there is no vibration that could place bodies"
            raise InputError("machine.drive", None, reason, code="stands-still")
        if self.speed is not None:
            low, high = computable_speeds(unheld)
            if not low <= abs(self.speed) <= high:
                raise InputError("study.speed", self.speed, f"must be a speed {_limits_text(unheld, low, high)}")
        if torques.poles(speed, speed):
            key = "machine.drive" if self.speed is None else "study.speed"
            reason = "this is the natural frequency of a vibration without damping, which is infinite there"
            raise InputError(key, speed, f"must be another speed: {reason}", code="resonance")

    def _search_range(self, machine: Machine) -> tuple[float, float]:
        """Return the range of speeds to search. Raises ``InputError`` where nothing drives the machine, or it does not fit."""
        speeds, _ = driven_speeds(machine)
        if self.range is not None:
            low, high = sorted(sense_of(machine, machine.rotor) * w for w in self.range)
            if low < 0:
                requirement = "must be speeds in the sense in which the drive turns"
                raise InputError("study.range", list(self.range), requirement, code="other-sense")
            least, most = computable_speeds(machine)
            if not least < high <= most:
                requirement = f"must be speeds {_limits_text(machine, least, most)}"
                raise InputError("study.range", list(self.range), requirement, code="limits")
            speeds = max(low, min(least, LOWEST * high)), high
        at, rotors = np.linspace(*speeds, _SAMPLES), [(net_torque(machine, r), sense_of(machine, r)) for r in machine.rotors]
        if not at.any() or not any(torque(sense * float(w)) for torque, sense in rotors for w in at):
            place, code = ("", "missing") if self.range is None else (" at these speeds", "not-driven")
            reason = f"nothing drives the machine{place}: the speed of the main rotor is required"
            raise InputError("study.speed", None, reason, code=code)
        return speeds

    def _map(self, unheld: Machine, torques: SteadyTorques) -> Cells | None:
        """Return the centres of the requested map's cells, None without a map.

        Raises ``InputError`` where there is no ratio of unbalances, or no closed form, or speeds are out of reach.
        """
        if self.axes is None:
            return None
        unit, c = unheld.units.speed, torques.coefficients
        axes, highest = self.axes_in(unit), computable_speeds(unheld)[1]
        if c is None or torques.size < 3 or any(h != 0 for h in torques.heads):
            requirement = "allowed for a rotor with at least two balancing bodies and nothing else that turns"
            raise InputError("study.axes", None, requirement, code="no-bodies")
        if not abs(c[0]):
            raise InputError("study.axes", None, "the rotor has no unbalance, so there is no ratio to it")
        if (patterns := pattern_count(torques)) > _MOST_PATTERNS:
            requirement = f"must be bodies with up to {_MOST_PATTERNS} arrangements in line, not {patterns}"
            raise InputError("study.axes", None, requirement)
        if axes["speed"][1] > highest:
            raise InputError("study.axes.speed", list(axes["speed"]), f"must be speeds up to {highest:.3g} {unit}".rstrip())
        edges = [np.linspace(low, high, cells + 1) for low, high, cells in (axes["speed"], axes["ratio"])]
        speeds, ratios = ((e[1:] + e[:-1]) / 2 for e in edges)
        if not torques.has_idle_bodies(speeds):
            reason = "separate torques act on balancing bodies, so that none of these states persists"
            raise InputError("study.axes", None, reason, code="own-torques")
        return speeds, ratios

    def solve(self, machine: Machine, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Search the states by the averaged equations, judge one by one by the full equations, then compute the map."""
        averaged_equations, torques, speeds, cells = prepared
        search = work.unit("search", partial(self._search, torques, speeds, work))
        describer = ConfigurationDescriber(AveragedStability(torques, averaged_equations))
        stabilities = [_NOT_YET if k < MOST_FULL else _TOO_MANY for k in range(len(search.states))]
        if not self.full:
            stabilities = [_NOT_REQUESTED] * len(search.states)
        states = [describer.describe(state, full) for state, full in zip(search.states, stabilities, strict=True)]
        fill = partial(
            state_synchronous,
            machine=machine, torques=torques, speeds=speeds, search=search, cells=cells, is_full=self.full,
        )  # fmt: skip
        yield Answer(machine.units, partial(fill, configurations=tuple(states)))
        if self.full and states:
            part = work.part("state", _SEARCH_SHARE, _STABILITY_SHARE if cells is not None else 1.0)
            for k, state in enumerate(self._judged_states(torques, states[:MOST_FULL], part)):
                states[k] = state
                yield Answer(machine.units, partial(fill, configurations=tuple(states)))
        if cells is not None:
            for tiles in _tiles(torques, *cells, work.part("map", _STABILITY_SHARE, 1.0)):
                yield Answer(machine.units, partial(fill, configurations=tuple(states), regions=tiles))

    def _search(self, torques: SteadyTorques, speeds: tuple[float, float] | None, work: Work) -> StateSearch:
        """Return all states."""
        work.report(0.0, "searching")
        search = all_states(torques, *speeds or (0.0, 0.0), partial(work.report, 0.0, "searching"))
        if speeds is None or self.range is not None or not driven_speeds(torques.machine)[1]:
            return search
        clause = "these are all in this range, but its" if search.complete else "the"
        end = "upper end is the program's choice, as the drive runs away without load: study.range sets another"
        return StateSearch(search.states, False, f"{search.evidence}; {clause} {end}")

    def _judged_states(self, torques: SteadyTorques, states: Sequence[Configuration], work: Work) -> Iterator[Configuration]:
        """Yield each state with its stability in the full equations, and the reason why the slow ones disagree."""
        full, count = FullStability(torques, self.inertia), len(states)
        for k, c in enumerate(states):
            part = work.part(f"{k + 1}", k / count, (k + 1) / count)
            stability = _stability(torques, full, c.state, part)
            disagreement = part.unit("disagreement", partial(full.disagreement, c.state, c.slow, stability))
            yield replace(c, full=stability, disagreement=disagreement)

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the force balances of up to 12 states, and below them the stability map if any."""
        return figure(result)


def _refuse_single(machine: Machine) -> None:
    """Refuse a machine with one turning body, which has no phases. Raises ``InputError``."""
    rotor, single = machine.rotor, "a single body has no phases"
    if machine.shaken_coordinate is not None:
        reason = f"{single}; study.kind = 'entrainment' shows whether the carrier's motion entrains it"
        raise InputError("machine.carrier.motion", None, reason, code="single-body")
    if machine.sliders:
        reason = f"{machine.sliders[0].name!r} slides in a guide that turns with it, and has no separate phase"
        advice = "study.kind = 'run-up' shows its motion"
        raise InputError("machine.bodies", None, f"only {rotor.name!r} turns freely: {reason}; {advice}", code="slider")
    advice = "study.kind = 'torque-balance' shows at which speeds it can turn"
    if not machine.drives or rotor.coordinate.prescribed_velocity is not None:
        advice = "study.kind = 'response' shows how it makes the carrier vibrate"
    raise InputError("machine.bodies", None, f"{single}; {advice}", code="single-body")


def _limits_text(machine: Machine, low: float, high: float) -> str:
    speeds = f"from {low:.3g} to {high:.3g} {machine.units.speed}".rstrip()
    return f"{speeds}, a thousandth of the lowest to a thousand times the highest natural frequency or speed of a drive"


def _stability(torques: SteadyTorques, full: FullStability, state: State, work: Work) -> Stability:
    """Return the stability of a state; that of a family, whose multipliers differ, only if its examined members agree."""
    work.report(0.0, "multipliers of the full equations")
    stability = work.unit("multipliers", partial(full.stability, state))
    if not state.dimension:
        return stability
    member_phases, members = family_members(torques, _MEMBERS).T, list[Stability]()
    for i, phases in enumerate(member_phases):
        work.report((i + 1) / (len(member_phases) + 1), "multipliers along a family")
        member = replace(state, phases=phases)
        members.append(work.unit(f"member {i + 1}", partial(full.stability, member)))
    return stability.family_stability(members)


def _tiles(torques: SteadyTorques, speeds: np.ndarray, ratios: np.ndarray, work: Work) -> Iterator[Regions]:
    """Yield the computed part of the map: some rows, of one ratio each, at a time."""
    rows, tiles = max(_CELLS // len(speeds), 2), list[Regions]()
    for begin in range(0, len(ratios), rows):
        work.report(begin / len(ratios), "the map")
        tiles.append(work.unit(f"rows from {begin}", partial(regions, torques, speeds, ratios[begin : begin + rows])))
        yield Regions.from_tiles(tiles)
