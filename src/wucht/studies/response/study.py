"""The question of a response, and its answer."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from wucht.analysis.throw import NUMBERS, Throw, steady_throw
from wucht.analysis.vibration import ForcedVibration
from wucht.dynamics.run_ups.operating_points import Operation, vibration_in_operation
from wucht.dynamics.run_ups.response_curves import (
    Maximum,
    ResponseCurve,
    centre_distance,
    eccentricity_of,
    greatest_value,
    largest_maximum,
    losses_of,
    phase_lags,
    response_curves,
    self_centring_speed,
)
from wucht.dynamics.run_ups.settled_from_rest import FromRest
from wucht.dynamics.run_ups.steady_phases import SteadyPhases
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer
from wucht.studies.foundation_variables import (
    ISOLATION,
    TRANSMISSIBILITY,
    forces_by_support,
    forces_in_words,
    state_static_loads,
)
from wucht.studies.from_rest_variables import FROM_REST_WORDS, state_ends_from_rest
from wucht.studies.key_types import BalancingBodies, Interval, Start, Whole
from wucht.studies.motion_variables import state_natural_vibrations
from wucht.studies.next_question import NextQuestion
from wucht.studies.response.figure import figure
from wucht.studies.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_MOST = 6  # maxima named one by one

Prepared = tuple[SteadyPhases, tuple[float, float]]  # the phases of the bodies, and the lowest and highest speed
Values = list[tuple[np.ndarray, np.ndarray, np.ndarray]]  # of each curve: amplitude, torque, and where bodies are stable


class Response(Study):
    """Amplitude, phase, self-centring and torque demand over the speed, at a steady speed.

    Every body turns in the sense of the drive of its rotor.
    """

    kind = "response"
    next_questions = (
        NextQuestion(
            "the speeds at which the motor, its load and the vibration are in balance", {"study.kind": "torque-balance"}
        ),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves = (("speed", "amplitude"), ("speed", "required_torque"))
    solves = "steady vibration of a linear carrier, in closed form"

    range: SI[Interval | None] = si("rad/s", "speed", default=None, help=(
        "lowest and highest speed, not negative; by default from 0.02 to 3 times the highest natural frequency, or to 1.5 "
        "times the speed that the drive reaches without vibration where that is more"
    ))  # fmt: skip
    points: Whole = Field(default=600, ge=2, le=100_000, description=(
        "number of speeds, evenly spaced over the range, to which those that resolve the resonances are added"
    ))  # fmt: skip
    bodies: BalancingBodies = None
    start: Composite[Start] = composite(default_factory=dict, description=(
        "phases of bodies that are held; of several rotors in steady phases, those that select the nearest stable configuration"
    ))  # fmt: skip

    def check(self) -> None:
        """Refuse negative speeds."""
        if self.range is not None and self.range[0] < 0:
            requirement = "must be a pair [low, high] of speeds of at least 0; bodies turn in the sense of their drives"
            raise InputError("study.range", list(self.range), requirement)

    def turning(self) -> str:
        """See ``Study``."""
        return "all bodies turn at each speed of the range"

    def prepare(self, machine: Machine, watch: Callable[[], None] | None = None) -> Prepared:
        """Return phases and speeds. Raises ``InputError`` where the start does not fit, or nothing is free to vibrate."""
        if not machine.free_carrier:
            requirement = "nothing is free to vibrate: a response needs a carrier on springs, and this one is"
            is_fixed = machine.shaken_coordinate is None
            carrier_state, code = ("fixed", "fixed") if is_fixed else ("moved as prescribed", "prescribed")
            raise InputError("machine.carrier", None, f"{requirement} {carrier_state}", code=code)
        steady = SteadyPhases.of(machine, self.start, self.bodies, watch)
        return steady, self.range or _speed_range(steady.machine)

    def solve(self, machine: Machine, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Search the decisive speeds; then run the machine up to find the state that is reached from rest."""
        steady, speed_range = prepared
        watch = partial(work.report, 0.0, "steady vibration")
        watch()
        operation = work.unit("operation", partial(vibration_in_operation, steady, watch))
        speeds, curves = response_curves(steady, speed_range, self.points)
        fill = partial(
            _state_response, steady=steady, speed_range=speed_range, speeds=speeds, curves=curves, operation=operation
        )
        yield Answer(machine.units, fill)
        if operation and steady.is_free:
            from_rest = FromRest.of(machine, machine.rotor.name, [o.state for o in operation], work)
            yield Answer(machine.units, partial(fill, from_rest=from_rest))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw amplitude, phase, centre of mass and torque over the speed."""
        return figure(result)


def _speed_range(machine: Machine) -> tuple[float, float]:
    """Return the default of ``range``."""
    natural = [f for f in natural_frequencies(machine).values() if f > 0]
    free = abs(free_speed(machine, machine.rotor) or 0.0)
    top = max([*natural, 0.0]) or free or 1.0
    return min(0.02 * top, 0.3 * min([*natural, top])), max(3 * top, 1.5 * free)


def _state_response(
    a: Answer,
    steady: SteadyPhases,
    speed_range: tuple[float, float],
    speeds: np.ndarray,
    curves: Sequence[ResponseCurve],
    operation: Sequence[Operation],
    from_rest: FromRest | None = None,
) -> None:
    """q = Re[z exp(i w t)], w t being the angle that a body has turned from its start.

    operation: the vibration at each stable operating point. from_rest: the ends of run-ups from rest, None without any.
    """
    machine = steady.machine
    free, eccentricity = free_speed(machine, machine.rotor), eccentricity_of(machine)
    for resonance in sorted({x for c in curves for x in c.undamped_resonances}):
        at = a.number_in_words(resonance, "speed")
        a.warn(f"the resonance at {at} is undamped: there the amplitude is infinite")
    a.warn(*steady.warnings)
    a.assume(*steady.assumptions)
    a.curve("speed", speeds, "speed", "speed")
    a.curve("direction", list(machine.free_labels), "direction")
    a.curve("body", [b.name for b in machine.bodies], "body")
    a.number("range", list(speed_range), "lowest and highest speed", "speed")
    a.line("range", "{range[0]} to {range[1]}")
    a.number("bodies", "steady" if steady.branches else "held", "phases of balancing bodies: held, or steady")
    inside = sorted(x for x in natural_frequencies(machine).values() if x > 0 and speed_range[0] <= x <= speed_range[1])
    critical = [x for x, below in zip(inside, [0.0, *inside], strict=False) if not math.isclose(x, below, rel_tol=1e-9)]
    a.number("critical_speeds", critical, "critical speeds in the range", "speed")
    a.line("critical", ", ".join(f"{{critical_speeds[{k}]}}" for k in range(len(critical))) or "none")
    state_natural_vibrations(a, machine)
    losses = losses_of(machine, speeds)
    values = _state_curves(a, steady, curves, speeds, eccentricity, losses)
    vibrates = _state_amplitudes(a, steady, curves, speeds, values)
    on_torque = _state_torques(a, curves, speeds, values)
    labels, throw = _state_at_free_speed(a, machine, curves, free)
    states = [o.state for o in operation]
    is_reached = [None] * len(states) if from_rest is None else from_rest.is_reached(machine.rotor.name, states)
    state_ends_from_rest(a, from_rest)
    _state_operation(a, machine, operation, is_reached)
    if vibrates or steady.branches:
        _add_operation_lines(a, operation, is_reached, throw)
    if on_torque:
        a.line("torque", on_torque)
    a.curve("loss_torque", losses, "torque of loads and bearings", "torque", "speed")
    a.curve("free_speed", free, "speed reached without vibration", "speed", "", in_summary=True)
    a.curve("eccentricity", eccentricity, "eccentricity of the rotor", "length", "", in_summary=True)
    is_excited = any(bool(c.vibration.force(speeds).any()) for c in curves)
    centring_speed = self_centring_speed(steady, eccentricity, speeds) if is_excited else None
    nearer = "speed from which the centre of mass is within the orbit of the axis"
    a.number("self_centring_speed", centring_speed, nearer, "speed")
    a.line("self-centred", "from {self_centring_speed} on: the centre of mass moves inside the orbit of the axis")
    a.sentence = _sentence(is_excited, critical, free, steady.list_labels(labels))
    if from_rest is not None and is_excited:
        points = [a.number_in_words(o.speed, "speed") + (f", {o.label}" if o.label else "") for o in operation]
        a.sentence += f"; in operation: {from_rest.sentence(is_reached, points)}"


def _state_curves(
    a: Answer,
    steady: SteadyPhases,
    curves: Sequence[ResponseCurve],
    w: np.ndarray,
    eccentricity: float,
    losses: np.ndarray,
) -> Values:
    """State the vibration over speeds (N,), of bodies in steady phases over configurations, each in its range."""
    machine, orbit, pieces = steady.machine, steady.machine.orbit_unit, steady.pieces(w)
    if steady.branches:
        names = np.array([p.label for p in pieces], str)
        a.curve("configuration_name", names, "steady phase configuration", "", "configuration", coordinate=True)
        stable, overlapping = (np.array([getattr(p, name) for p in pieces], np.int8) for name in ("stable", "overlapping"))
        a.curve("stable", stable, "stable with the rotor held at the speed", "", "configuration speed")
        a.curve("overlapping", overlapping, "bodies of a track overlap", "", "configuration")

    def state(name: str, values: Sequence[np.ndarray], what: str, unit: str, over: str = "speed") -> None:
        if not steady.branches:
            a.curve(name, values[0], what, unit, over)
            return
        of_pieces = np.array([np.where(p.inside, values[p.branch], np.nan) for p in pieces])
        a.curve(name, of_pieces, what, unit, f"configuration {over}")

    vibrations = [c.vibration_at(w) for c in curves]
    z, amplitudes = [v.displacement(w)[0].T for v in vibrations], [v.amplitude(w)[0] for v in vibrations]
    torques = [v.torque(w)[0] for v in vibrations]
    lags = [phase_lags(machine, v, w, of_curve) for v, of_curve in zip(vibrations, z, strict=True)]
    centres = [centre_distance(steady, v, eccentricity, w) for v in vibrations]
    on_bodies = [np.array([v.torque_on(w, [i])[0] for i in range(len(machine.bodies))]) for v in vibrations]
    along = "direction speed"
    state("displacement_real", [x.real for x in z], "displacement at the start of a turn (r: rad)", "length", along)
    state("displacement_imag", [x.imag for x in z], "displacement a quarter turn before (r: rad)", "length", along)
    state("displacement_amplitude", [np.abs(x) for x in z], "amplitude of the carrier (r: rad)", "length", along)
    state("lag", lags, "phase lag behind the unbalance", "rad", along)
    state("amplitude", amplitudes, "amplitude of the axis", orbit)
    state("minor_axis", [v.minor_amplitude(w) for v in vibrations], "semi-minor axis of the orbit", orbit)
    state("centre_distance", centres, "distance of the centre of mass", "length")
    state("vibration_torque", torques, "torque of the vibration", "torque")
    state("required_torque", [t + losses for t in torques], "torque required", "torque")
    state("torque_on_body", on_bodies, "torque of the vibration on a body", "torque", "body speed")
    stable_masks = list[np.ndarray]()
    for k in range(len(curves)):
        masks = [p.stable for p in pieces if p.branch == k and not p.overlapping]
        stable_masks.append(np.any(masks, axis=0) if masks else np.full(len(w), not pieces))
    return list(zip(amplitudes, torques, stable_masks, strict=True))


def _state_amplitudes(
    a: Answer, steady: SteadyPhases, curves: Sequence[ResponseCurve], speeds: np.ndarray, values: Values
) -> bool:
    """State the largest amplitudes, and return whether anything vibrates where bodies are stable."""
    peaks = [m for c in curves for m in c.maxima(c.peaks, c.amplitude(c.peaks))]
    greatest = [m for amplitude, _, stable in values for m in greatest_value(speeds, amplitude, stable)]
    largest = largest_maximum([*greatest, *(m for m in peaks if math.isinf(m.value) and m.stable)])
    peak_speed = largest.speed if largest is not None and largest.value != 0 else None
    orbit, in_phases = steady.machine.orbit_unit, " in stable steady phases" if steady.branches else ""
    a.number("peak_amplitude", largest and largest.value, "largest amplitude of the axis", orbit, headline=True)
    a.number("peak_speed", peak_speed, "speed of the largest amplitude", "speed")
    if largest is not None and peak_speed is not None:
        most = "{peak_amplitude}" if math.isfinite(largest.value) else "infinite"
        a.line("amplitude", f"{most} at most, at {{peak_speed}}{in_phases}")
    elif steady.branches:
        a.line("amplitude", "there are no stable steady phases" if largest is None else f"none{in_phases}")
    columns: dict[str, type] = {"speed": float, "amplitude": float} | ({"configuration": str} if steady.branches else {})
    _state_maxima(a, peaks, "peaks", "largest amplitudes", ("amplitude", "largest amplitude", orbit), "peak", columns)
    further = [k for k in _stable_indices(peaks) if peaks[k].speed != peak_speed]
    sizes = ["infinite" if math.isinf(peaks[k].value) else f"{{peaks[{k}].amplitude}}" for k in further[:_MOST]]
    listing = ", ".join(f"{size} at {{peaks[{k}].speed}}" for size, k in zip(sizes, further, strict=False))
    if further:
        a.line("also", f"{listing} and {len(further) - _MOST} more" if len(further) > _MOST else listing)
    return peak_speed is not None


def _state_torques(a: Answer, curves: Sequence[ResponseCurve], speeds: np.ndarray, values: Values) -> str:
    """State the largest torques, and return the text of their line, which stands after those on the operation."""
    peaks = [m for c in curves for m in c.maxima(c.torque_peaks, c.vibration.torque(c.torque_peaks)[0])]
    hardest = largest_maximum([m for _, torque, stable in values for m in greatest_value(speeds, torque, stable)])
    peak_speed = hardest.speed if hardest is not None and hardest.value > 0 else None
    a.number("peak_torque", hardest and hardest.value, "largest torque of the vibration", "torque", headline=True)
    a.number("peak_torque_speed", peak_speed, "speed of the largest torque", "speed")
    _state_maxima(a, peaks, "torque_peaks", "largest torques of the vibration", ("torque", "largest torque", "torque"))
    further = [k for k in _stable_indices(peaks)[:_MOST] if peaks[k].speed != peak_speed]
    also = "".join(f", also {{torque_peaks[{k}].torque:.4g}} at {{torque_peaks[{k}].speed}}" for k in further)
    return "" if peak_speed is None else f"of the vibration: at most {{peak_torque:.4g}} at {{peak_torque_speed}}{also}"


def _state_maxima(
    a: Answer,
    maxima: Sequence[Maximum],
    name: str,
    what: str,
    value: tuple[str, str, str],
    over: str = "",
    columns: Mapping[str, type] | None = None,
) -> None:
    """State maxima in a table. value: name of their column, in words, and its unit. columns: those that are variables."""
    of_bodies = [m for m in maxima if m.label]
    column, words, unit = value
    a.table(
        name, what, over, columns, (),
        speed=([m.speed for m in maxima], f"speed of a {words}", "speed"),
        **{column: ([m.value for m in maxima], words, unit)},
        configuration=([m.label for m in of_bodies], "configuration there"),
        stable=([m.stable for m in of_bodies], "whether it is stable there"),
    )  # fmt: skip


def _stable_indices(maxima: Sequence[Maximum]) -> list[int]:
    """Return the indices of the maxima at which steady phases of balancing bodies, if any, are stable."""
    return [k for k, m in enumerate(maxima) if m.stable or not m.label]


def _state_at_free_speed(
    a: Answer, machine: Machine, curves: Sequence[ResponseCurve], free: float | None
) -> tuple[list[str], Throw | None]:
    """State the vibration at the speed that the drive reaches without it; return the stable configurations and the throw."""
    speeds, at_free = np.array([] if free is None else [abs(free)]), list[tuple[Maximum, ForcedVibration]]()
    for c in curves:
        there = c.maxima(speeds, c.amplitude(speeds))
        at_free += [(m, c.vibration) for m in there if (m.stable and math.isfinite(m.value)) or math.isinf(m.value)]
    labels, throw, amplitude = [m.label for m, _ in at_free if m.label], None, None
    if at_free:
        widest, vibration = max(at_free, key=lambda pair: pair[0].value)
        amplitude = widest.value
        throw = steady_throw(machine, vibration, widest.speed) if math.isfinite(amplitude) else None
    a.number("amplitude_at_free_speed", amplitude, "amplitude at the speed reached without vibration", machine.orbit_unit)
    a.number("configurations_at_free_speed", labels, "stable configurations at that speed")
    numbers = None if throw is None else throw.numbers
    a.number("throw_at_free_speed", numbers, "throw of the carrier at that speed", parts=NUMBERS)
    return labels, throw


def _state_operation(a: Answer, machine: Machine, operation: Sequence[Operation], is_reached: Sequence[bool | None]) -> None:
    """State the vibration at the stable operating points."""
    parts = {
        "speed": ("speed in operation", a.unit("speed")),
        "configuration": ("configuration there", ""),
        "amplitude": ("amplitude of the axis there", machine.orbit_unit),
        "reached_from_rest": FROM_REST_WORDS,
        "transmissibility": TRANSMISSIBILITY,
    } | NUMBERS
    rows = [
        {"speed": o.speed, "configuration": o.label, "amplitude": o.amplitude, "reached_from_rest": yes}
        | ({} if o.throw is None else o.throw.numbers)
        | ({} if o.foundation is None else {"transmissibility": o.foundation.transmissibility})
        for o, yes in zip(operation, is_reached, strict=True)
    ]
    a.number("operation", rows, "stable steady speeds at which the torques balance, with the vibration there", parts=parts)
    fastest = max(operation, key=lambda o: abs(o.speed), default=None)
    a.number("operating_speed", fastest and fastest.speed, "fastest of these speeds", "speed", headline=True)
    amplitude = fastest and fastest.amplitude
    a.number("operating_amplitude", amplitude, "amplitude of the axis there", machine.orbit_unit, headline=True)
    if fastest is not None and fastest.throw is not None:
        for name in ("stroke", "machine_number"):
            what, unit = NUMBERS[name]
            a.number(name, fastest.throw.numbers[name], f"{what}, there", unit, headline=True)
    if fastest is not None and fastest.foundation is not None:
        a.number("transmissibility", fastest.foundation.transmissibility, f"{TRANSMISSIBILITY[0]}, there")
        in_operation = "amplitude of the force of each support on the foundation there, along x and y"
        a.number("foundation_force_amplitudes", forces_by_support(fastest.foundation.amplitudes), in_operation, "N")
        state_static_loads(a, machine)


def _add_operation_lines(
    a: Answer, operation: Sequence[Operation], is_reached: Sequence[bool | None], throw_at_free_speed: Throw | None
) -> None:
    """Add the vibration at each operating point; at the speed without vibration where no torque drives the machine."""
    for k, (o, yes) in enumerate(zip(operation[:_MOST], is_reached, strict=False)):
        label = (f", {o.label}" if o.label else "") + ("; reached from rest" if yes else "")
        a.line("in operation", f"{{amplitude}} at {{speed}}{label}", at=f"operation[{k}]")
        _add_throw_line(a, o.throw, f"operation[{k}]")
        if o.foundation is not None:
            a.line("foundation", f"{forces_in_words(o.foundation.amplitudes)}", at=f"operation[{k}]")
            a.line("isolation", ISOLATION, at=f"operation[{k}]")
    if not operation:
        a.line("in operation", "{amplitude_at_free_speed} at {free_speed}")
        _add_throw_line(a, throw_at_free_speed, "throw_at_free_speed")


def _add_throw_line(a: Answer, throw: Throw | None, at: str) -> None:
    if throw is not None:
        weight = f"{throw.acceleration:.4g} m/s\u00b2, machine number {throw.machine_number:.3g}"
        a.line("", f"stroke {{stroke}} peak to peak, {weight}", at=at)


def _sentence(is_excited: bool, critical: list[float], free: float | None, labels: str) -> str:
    if not is_excited:
        return "nothing excites the carrier: the unbalances are zero or cancel"
    count = len(critical)
    sentence = f"{count or 'no'} critical speed{'' if count == 1 else 's'} in the range"
    if free and critical:
        below = sum(c < abs(free) for c in critical)
        relation = "above" if below == count else "below" if not below else "between"
        sentence += f"; the drive runs {relation} {'it' if count == 1 else 'them'}"
    return f"{sentence}; bodies stable there: {labels}" if labels and free else sentence
