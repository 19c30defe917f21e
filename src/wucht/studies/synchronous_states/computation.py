"""Question and machine -> plan -> findings: the machine in synchronous rotation, its states, and their stability."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

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
    DEFAULT_SPEED,
    LOWEST,
    MOST_BODIES,
    driven_speeds,
    free_speed,
    machine_at_speed,
    natural_frequencies,
    net_torque,
    sense_of,
)
from wucht.studies.synchronous_states.spec import SynchronousStates

_MOST_PATTERNS = 64  # arrangements of bodies in line, of a map
_SLOWER, _FASTER = 1e-3, 1e3  # of the lowest and the highest speed of the machine: limits of the computation
_SAMPLES = 1001


@dataclass(frozen=True)
class Plan:
    """The plan of a search for synchronous states.

    machine: as given; that of the torques turns synchronously.

    speeds: lowest and highest of the search, in the main rotor's sense, None where the speed is given. is_limit_chosen: True if
    the highest is the program's choice. map: the centres of a stability map's cells: speeds (N,), in this sense, and ratios
    (M,).
    """

    spec: SynchronousStates
    machine: Machine
    averaged_equations: AveragedEquations
    torques: SteadyTorques
    speeds: tuple[float, float] | None
    is_limit_chosen: bool
    map: tuple[np.ndarray, np.ndarray] | None


def prepare(spec: SynchronousStates, machine: Machine) -> Plan:
    """Return the plan. Raises ``InputError`` where the machine has no phases, or is outside those of the averaged equations."""
    if len(machine.bodies) < 2:
        _refuse_single(machine)
    if len(machine.bodies) > MOST_BODIES:
        raise InputError("machine.bodies", len(machine.bodies), f"there must be at most {MOST_BODIES}, the main rotor included")
    if spec.range is not None and machine.rotor.coordinate.prescribed_velocity is not None:
        raise InputError(
            "study.range", list(spec.range), "not allowed where the speed of the main rotor is given", code="prescribed"
        )
    steady, unheld = machine_at_speed(machine, spec.speed), machine_at_speed(machine, None)
    averaged_equations = averaged_equations_of(steady, keeps_inertia(steady, spec.inertia))
    torques, speeds, is_limit_chosen = SteadyTorques.from_averaged_equations(averaged_equations), None, False
    if torques.fixed_speed is None:
        speeds, is_limit_chosen = _search_range(steady, spec.range)
    else:
        _check_speed(spec, unheld, torques, torques.fixed_speed)
    has_closed_form(torques, *speeds or (0.0, 0.0))
    return Plan(spec, machine, averaged_equations, torques, speeds, is_limit_chosen, _map(spec, unheld, torques))


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


def _check_speed(spec: SynchronousStates, unheld: Machine, torques: SteadyTorques, speed: float) -> None:
    """Refuse a given speed at which nothing can be computed. Raises ``InputError``."""
    if speed <= 0:
        raise InputError(
            "machine.drive",
            None,
            "the main rotor does not turn: there is no vibration that could place bodies",
            code="stands-still",
        )
    if spec.speed is not None:
        low, high = _limits(unheld)
        if not low <= abs(spec.speed) <= high:
            raise InputError("study.speed", spec.speed, f"must be a speed {_limits_text(unheld, low, high)}")
    if torques.poles(speed, speed):
        key = "machine.drive" if spec.speed is None else "study.speed"
        reason = "this is the natural frequency of a vibration without damping, which is infinite there"
        raise InputError(key, speed, f"must be another speed: {reason}", code="resonance")


def _search_range(machine: Machine, given_range: tuple[float, float] | None) -> tuple[tuple[float, float], bool]:
    """Return the range of speeds to search, and True if the program chooses its upper end.

    Raises ``InputError`` where nothing drives the machine, or the given range does not fit.
    """
    speeds, is_limit_chosen = driven_speeds(machine)
    if given_range is not None:
        low, high = sorted(sense_of(machine, machine.rotor) * w for w in given_range)
        if low < 0:
            raise InputError(
                "study.range", list(given_range), "must be speeds in the sense in which the drive turns", code="other-sense"
            )
        least, most = _limits(machine)
        if not least < high <= most:
            raise InputError(
                "study.range", list(given_range), f"must be speeds {_limits_text(machine, least, most)}", code="limits"
            )
        speeds, is_limit_chosen = (max(low, min(least, LOWEST * high)), high), False
    at, rotors = np.linspace(*speeds, _SAMPLES), [(net_torque(machine, r), sense_of(machine, r)) for r in machine.rotors]
    if not at.any() or not any(torque(sense * float(w)) for torque, sense in rotors for w in at):
        place, code = ("", "missing") if given_range is None else (" at these speeds", "not-driven")
        reason = f"nothing drives the machine{place}: the speed of the main rotor is required"
        raise InputError("study.speed", None, reason, code=code)
    return speeds, is_limit_chosen


def _limits(machine: Machine) -> tuple[float, float]:
    """Return the lowest and the highest computable speed, by the machine's natural frequencies and drives."""
    machine_speeds = [*natural_frequencies(machine).values(), *(abs(free_speed(machine, r) or 0.0) for r in machine.rotors)]
    machine_speeds = [w for w in machine_speeds if w > 0 and math.isfinite(w)] or [DEFAULT_SPEED]
    return _SLOWER * min(machine_speeds), _FASTER * max(machine_speeds)


def _limits_text(machine: Machine, low: float, high: float) -> str:
    speeds = f"from {low:.3g} to {high:.3g} {machine.units.speed}".rstrip()
    return f"{speeds}, a thousandth of the lowest to a thousand times the highest natural frequency or speed of a drive"


def _map(spec: SynchronousStates, unheld: Machine, torques: SteadyTorques) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the centres of the requested map's cells, None without a map.

    Raises ``InputError`` where there is no ratio of unbalances, or no closed form, or speeds are out of reach.
    """
    if spec.axes is None:
        return None
    unit, c = unheld.units.speed, torques.coefficients
    axes, highest = spec.axes_in(unit), _limits(unheld)[1]
    if c is None or torques.size < 3 or any(h != 0 for h in torques.heads):
        requirement = "allowed for a rotor with at least two balancing bodies and nothing else that turns"
        raise InputError("study.axes", None, requirement, code="no-bodies")
    if not abs(c[0]):
        raise InputError("study.axes", None, "the rotor has no unbalance, so there is no ratio to it")
    if (patterns := pattern_count(torques)) > _MOST_PATTERNS:
        raise InputError("study.axes", None, f"must be bodies with up to {_MOST_PATTERNS} arrangements in line, not {patterns}")
    if axes["speed"][1] > highest:
        raise InputError("study.axes.speed", list(axes["speed"]), f"must be speeds up to {highest:.3g} {unit}".rstrip())
    edges = [np.linspace(low, high, cells + 1) for low, high, cells in (axes["speed"], axes["ratio"])]
    speeds, ratios = ((e[1:] + e[:-1]) / 2 for e in edges)
    if not torques.has_idle_bodies(speeds):
        raise InputError(
            "study.axes",
            None,
            "separate torques act on balancing bodies, so that none of these states persists",
            code="own-torques",
        )
    return speeds, ratios


MOST_FULL = 64  # states whose multipliers are computed
_MEMBERS = 7  # members of a family, besides its representative
_CELLS = 4000  # of a tile of the map
_SEARCH_SHARE, _STABILITY_SHARE = 0.1, 0.8  # shares of the work after the search, and before the map
_NOT_REQUESTED = Stability.without_verdict("the multipliers were not requested")
_TOO_MANY = Stability.without_verdict(f"multipliers are computed for {MOST_FULL} states at most")
_NOT_YET = Stability.without_verdict("its multipliers are not computed yet")


@dataclass(frozen=True)
class Findings:
    """The states of the search, with their descriptions in the same order, and the computed part of the map."""

    search: StateSearch
    configurations: tuple[Configuration, ...]
    map: Regions | None = None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the states by the averaged equations, then one by one by the full equations, then with the map."""
    search = work.unit("search", partial(_search, plan, work))
    describer = ConfigurationDescriber(AveragedStability(plan.torques, plan.averaged_equations))
    full = [
        _NOT_REQUESTED if not plan.spec.full else _NOT_YET if k < MOST_FULL else _TOO_MANY for k in range(len(search.states))
    ]
    configurations = [
        describer.describe(state, full_stability) for state, full_stability in zip(search.states, full, strict=True)
    ]
    yield Findings(search, tuple(configurations))
    if plan.spec.full and search.states:
        part = work.part("state", _SEARCH_SHARE, _STABILITY_SHARE if plan.map is not None else 1.0)
        for k, configuration in enumerate(_full_configurations(plan, tuple(configurations[:MOST_FULL]), part)):
            configurations[k] = configuration
            yield Findings(search, tuple(configurations))
    if plan.map is not None:
        for tiles in _tiles(plan.torques, *plan.map, work.part("map", _STABILITY_SHARE, 1.0)):
            yield Findings(search, tuple(configurations), tiles)


def _search(plan: Plan, work: Work) -> StateSearch:
    """Return all states."""
    work.report(0.0, "searching")
    search = all_states(plan.torques, *plan.speeds or (0.0, 0.0), partial(work.report, 0.0, "searching"))
    if not plan.is_limit_chosen:
        return search
    clause = "these are all in this range, but its" if search.complete else "the"
    end = "upper end is the program's choice, as the drive runs away without load: study.range sets another"
    return StateSearch(search.states, False, f"{search.evidence}; {clause} {end}")


def _full_configurations(plan: Plan, states: Sequence[Configuration], work: Work) -> Iterator[Configuration]:
    """Yield each state with its stability in the full equations, and the reason why the slow ones disagree."""
    full, count = FullStability(plan.torques, plan.spec.inertia), len(states)
    for k, c in enumerate(states):
        part = work.part(f"{k + 1}", k / count, (k + 1) / count)
        stability = _stability(plan, full, c.state, part)
        disagreement = part.unit("disagreement", partial(full.disagreement, c.state, c.slow, stability))
        yield replace(c, full=stability, disagreement=disagreement)


def _stability(plan: Plan, full: FullStability, state: State, work: Work) -> Stability:
    """Return the stability of a state; that of a family, whose multipliers differ, only if its examined members agree."""
    work.report(0.0, "multipliers of the full equations")
    stability = work.unit("multipliers", partial(full.stability, state))
    if not state.dimension:
        return stability
    member_phases, verdicts = family_members(plan.torques, _MEMBERS).T, [stability.stable]
    for i, phases in enumerate(member_phases):
        work.report((i + 1) / (len(member_phases) + 1), "multipliers along a family")
        member = replace(state, phases=phases)
        verdicts.append(work.unit(f"member {i + 1}", partial(full.stability, member)).stable)
    decisions = [stable for stable in verdicts if stable is not None]
    if stability.stable is None or len(set(decisions)) < 2:
        return stability
    state_verdict = "stable" if stability.stable else "not stable"
    reason = f"stable at {sum(decisions)} of {len(decisions)} examined members of the family, {state_verdict} at this one"
    return Stability(None, stability.exponents, reason)


def _tiles(torques: SteadyTorques, speeds: np.ndarray, ratios: np.ndarray, work: Work) -> Iterator[Regions]:
    """Yield the computed part of the map: some rows, of one ratio each, at a time."""
    rows, tiles = max(_CELLS // len(speeds), 2), list[Regions]()
    for begin in range(0, len(ratios), rows):
        work.report(begin / len(ratios), "the map")
        tiles.append(work.unit(f"rows from {begin}", partial(regions, torques, speeds, ratios[begin : begin + rows])))
        yield Regions.from_tiles(tiles)
