"""The answer of a sweep: of a machine its ramps and jumps, of equations what the motion tends to at each value."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict

import numpy as np

from wucht.dynamics.limit_sets.stepped_parameter import Way, range_of_history, state_jumps, unstable_values
from wucht.dynamics.sweeps.jumps import Jump, hysteresis
from wucht.dynamics.sweeps.moving import MovedMachine, SweepLeg, is_too_fast
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.machines.subject import Subject
from wucht.schema import Parameter
from wucht.studies.answer import Answer
from wucht.studies.sweep.figure import SENSE

_FREE_SPEEDS = 21

Ends = tuple[float, float]  # lowest and highest value of the parameter


def settling_doubts(
    moved_machine: MovedMachine, settled_leg: SweepLeg, steady: bool, occasion: str, legs: Sequence[SweepLeg] = ()
) -> list[str]:
    """Warnings if the machine did not settle, or did not follow a ramp to its end. legs: of all ramps so far."""
    doubts, speed = list[str](), f"{settled_leg.speed:.5g} {moved_machine.machine.units.speed}".strip()
    if not steady:
        doubts.append(f"the machine did not settle {occasion}: its speed was still changing at {speed}")
    if is_too_fast(settled_leg, legs):
        doubts.append(
            f"the sweep is too fast: {occasion} the speed still changed from {legs[-1].speed:.5g} to {speed}; "
            f"give a rate below {moved_machine.pace.rate:.3g} {moved_machine.pace.rate_unit}"
        )
    return doubts


def free_speeds(machine: Machine, parameter: Parameter, ends: Ends) -> tuple[np.ndarray, np.ndarray]:
    """Values (21,) of the parameter, and the speeds of the main rotor without vibration there, NaN where there is none."""
    grid = np.linspace(*ends, _FREE_SPEEDS)
    free = [free_speed(machine.with_unchecked_values({parameter.path: float(v)}), machine.rotor) for v in grid]
    return grid, np.array(free, float)


def state_machine_jumps(a: Answer, machine: Machine, parameter: Parameter, jumps: Sequence[Jump]) -> None:
    """State the jumps, in the summary with the value of the parameter under its path."""
    length = machine.orbit_unit
    parts = {
        parameter.path: (parameter.full_name, parameter.unit),
        "from_speed": ("speed before the jump", a.unit("speed")),
        "to_speed": ("speed after the jump", a.unit("speed")),
        "direction": ("direction in which the parameter moves", ""),
        "from_amplitude": ("amplitude before the jump", length),
        "to_amplitude": ("amplitude after the jump", length),
        "fold": ("whether the branch ends in a fold there", ""),
        "only_seen": ("whether it is known from the ramp only", ""),
        "bracket": ("values between which the branch ends", parameter.unit),
    }
    rows = [{parameter.path if key == "value" else key: x for key, x in asdict(j).items()} for j in jumps]
    a.number("jumps", rows, "jumps, in the order in which they occur", parts=parts)
    columns = {"value": parameter.path, "from": "from_speed", "to": "to_speed"}
    columns |= {name: name for name in ("from_amplitude", "to_amplitude")}
    for name, part in columns.items():
        a.curve(f"jump_{name}", [row[part] for row in rows], *parts[part], "jump")
    a.curve("jump_upward", [int(j.direction == "up") for j in jumps], "1 where the parameter rises", "", "jump")
    for j in jumps:
        if j.only_seen:
            a.warn(
                f"the jump near {j.value:.5g} is only known to lie between {j.bracket[0]:.6g} and {j.bracket[1]:.6g}: with the "
                "parameter held before it, the machine does not remain in the state of the sweep; a lower rate shows where it "
                "settles"
            )


def state_question(
    a: Answer, moved_machine: MovedMachine, parameter: Parameter, ends: Ends, is_rate_chosen: bool, jump_tolerance: float
) -> None:
    """State the swept parameter and its rate."""
    pace, (low, high) = moved_machine.pace, ends
    a.number("along", parameter.path, "swept parameter")
    a.number("along_unit", parameter.unit, "unit of the swept parameter")
    a.number("range", [low, high], "lowest and highest value of the parameter", parameter.unit)
    a.number("rate", pace.rate, "rate of the parameter", pace.rate_unit)
    a.number("rate_unit", pace.rate_unit, "unit of the rate")
    a.number("rate_chosen", is_rate_chosen, "whether the rate is the program's choice")
    a.number("jump_tolerance", jump_tolerance, "relative tolerance of the values of jumps")
    chosen = " (chosen so that the machine follows)" if is_rate_chosen else ""
    a.line("sweep", f"{{along}} from {low:.5g} to {high:.5g}{_unit_after(parameter)} at {{rate:.3g}}{chosen}")


def state_free_speeds(a: Answer, parameter: Parameter, grid: np.ndarray, free: np.ndarray) -> None:
    """State the speed of the drive without vibration."""
    a.curve("grid", grid, parameter.full_name, parameter.unit)
    a.curve("free_speed", free, "speed reached without vibration", "speed", "grid")


def state_ramps(
    a: Answer, moved_machine: MovedMachine, parameter: Parameter, ramps: Mapping[str, tuple[SweepLeg, ...]],
    jumps: Sequence[Jump],
) -> None:  # fmt: skip
    """State the readings of the ramps, NaN where one ended early, and where they depend on the direction."""
    length, samples, over = moved_machine.machine.orbit_unit, moved_machine.pace.samples, "direction sample"

    def readings(key: str) -> np.ndarray:
        rows = [[getattr(leg, key) for leg in legs] for legs in ramps.values()]
        return np.array([row + [math.nan] * (samples - len(row)) for row in rows]).reshape(len(rows), samples)

    a.curve("direction", list(ramps) or np.empty(0, "U4"), "direction of the sweep")
    a.curve("value", readings("value"), parameter.full_name, parameter.unit, over, coordinate=True)
    a.curve("speed", readings("speed"), "mean speed", "speed", over)
    a.curve("min_speed", readings("low"), "least speed, mean over a turn", "speed", over)
    a.curve("max_speed", readings("high"), "largest speed, mean over a turn", "speed", over)
    a.curve("amplitude", readings("amplitude"), "amplitude of the axis", length, over)
    a.curve("energy_residual", readings("energy_residual"), "energy residual, relative", "", over)
    legs = [leg for of_ramp in ramps.values() for leg in of_ramp]
    peak, residual = (max((getattr(leg, key) for leg in legs), default=None) for key in ("amplitude", "energy_residual"))
    between = hysteresis(jumps)
    a.number("hysteresis", between, "range in which the state depends on the direction", parameter.unit)
    a.number("peak_amplitude", peak, "largest amplitude of the axis", length, headline=True)
    a.number("energy_residual", residual, "largest relative error of the energy balance")
    ends = {way: {"from_speed": r[0].speed, "to_speed": r[-1].speed} for way, r in ramps.items() if r}
    speed = a.unit("speed")
    parts = {"from_speed": ("speed at its start", speed), "to_speed": ("speed at its end", speed)}
    a.number("ends", ends, "speeds at the ends of each ramp", parts=parts)
    for way in ends:
        a.line(way, "{from_speed} to {to_speed}", at=f"ends.{way}")
    for k, jump in enumerate(jumps):
        a.line("jump", f"{SENSE[jump.direction]}, at {parameter.path} = {jump.value:.6g}{_unit_after(parameter)}:")
        a.line("", "speed {from_speed} to {to_speed}", at=f"jumps[{k}]")
        a.line("", "amplitude {from_amplitude} to {to_amplitude}", at=f"jumps[{k}]")
    if between:
        low, high = between
        text = f"between {low:.6g} and {high:.6g}{_unit_after(parameter)} the state depends on the direction of the sweep"
        a.line("hysteresis", text)
    if jumps:
        a.line("accuracy", "{jump_tolerance:.0e} of these values, obtained with {along} held: independent of the rate")
    a.line("energy", "balance closed to {energy_residual:.1e}")


def state_sentence(a: Answer, parameter: Parameter, ends: Ends, jumps: Sequence[Jump], is_complete: bool) -> None:
    """State the jumps in a sentence, or why the sweep ended early."""
    if a.failure or not is_complete:
        a.sentence = "the sweep failed" if a.failure else "the sweep was interrupted"
        a.verdict = a.sentence.upper()
        a.warn(a.failure or "the sweep is not finished: jumps may be missing")
        return
    changes = list[str]()
    for j in jumps:
        change = f"speed jumps from {j.from_speed:.5g} to {j.to_speed:.5g}"
        if math.isclose(j.from_speed, j.to_speed, rel_tol=1e-4):
            change = f"amplitude jumps from {j.from_amplitude:.4g} to {j.to_amplitude:.4g}"
        changes.append(f"at {parameter.value_text(j.value)} {SENSE[j.direction]} the {change}")
    low, high = ends
    calm = f"no jump: the machine follows {parameter.sentence_name} between {low:.5g} and {high:.5g}"
    a.sentence = "; ".join(changes) or calm
    a.verdict = _count_in_words(jumps)


def _unit_after(parameter: Parameter) -> str:
    return f" {parameter.unit}" if parameter.unit else ""


def _count_in_words(jumps: Sequence[object]) -> str:
    return {0: "NO JUMP", 1: "ONE JUMP"}.get(len(jumps), f"{len(jumps)} JUMPS")


def system_answer(subject: Subject, path: str, ends: Ends, span: float, ways: Mapping[str, Way]) -> Answer:
    """Return the answer of a sweep of equations. span: the time at each value. ways: the completed ones."""
    a, system, (low, high) = Answer(), subject.system, ends
    names, parameter = system.state_names, f"parameter {path}"
    failures = [way.failure for way in ways.values() if way.failure]
    a.failure = next(iter(failures), None)
    a.warn(*failures)
    a.attribute(along=path, subject="system")
    rows_of_states = [i for i, s in enumerate(system.states) if s not in system.angles]
    jumps = [(direction, jump) for direction, way in ways.items() for jump in state_jumps(way, names, rows_of_states)]
    between = range_of_history(ways["up"], ways["down"], rows_of_states) if {"up", "down"} <= ways.keys() else None
    a.number("along", path, "swept parameter")
    a.line("sweep", f"{path} in steps, a time of {span:.4g} at each")
    rows = [
        {path: j.value, "value": j.value, "state": j.state, "from": j.before, "to": j.after, "direction": direction}
        for direction, j in jumps
    ]
    parts = {
        path: (parameter, ""), "value": (parameter, ""), "state": ("state that jumps most", ""),
        "from": ("largest value of that state before the jump", ""), "to": ("largest value of that state after it", ""),
        "direction": ("direction in which the parameter moves", ""),
    }  # fmt: skip
    a.number("jumps", rows, "jumps, in the order in which they occur", parts=parts)
    sentences = list[str]()
    for direction, j in jumps:
        a.line("jump", f"{direction}, at {path} = {j.value:.6g}: {j.state} {j.before:.5g} to {j.after:.5g}")
        sentences.append(f"at {path} = {j.value:.5g} ({direction}) {j.state} jumps from {j.before:.4g} to {j.after:.4g}")
    sentences = sentences or [f"no jump for {path} between {low:.5g} and {high:.5g}"]
    a.verdict = _count_in_words(jumps)
    if between:
        dependence = f"the motion depends on the direction {_range_in_words(*between)}"
        sentences.append(dependence)
        a.verdict += f", {dependence}"
    a.sentence = "; ".join(sentences)
    a.number("hysteresis", between and list(between), "range in which the motion depends on the direction")
    a.number("span", span, "time at each value of the parameter")
    a.curve("direction", list(ways), "direction of the sweep")
    a.curve("value", np.stack([way.values for way in ways.values()]), parameter, "", "direction step")
    a.curve("state", list(names), "state")
    a.curve("is_angle", [int(s in system.angles) for s in system.states], "1 of an angle", "", "state", coordinate=True)
    words = {"low": "least value", "high": "largest value", "mean": "mean value"}
    for name, word in words.items():
        values = np.stack([getattr(way, name) for way in ways.values()])
        a.curve(name, values, f"{word} of the state", "", "direction state step")
    maxima = np.stack([way.maxima for way in ways.values()])
    a.curve("maxima", maxima, "maximum of the state", "", "direction state step peak")
    for direction, way in ways.items():
        values = unstable_values(subject, path, way)
        if len(values):
            a.warn(
                f"{direction}: for {path} {_range_in_words(values.min(), values.max())} the motion rests on an unstable "
                "equilibrium, which any disturbance leaves; jumps do not show there. Begin beside it (study.start)"
            )
    return a


def _range_in_words(low: float, high: float) -> str:
    return f"between {low:.5g} and {high:.5g}" if high > low else f"at {low:.5g}"
