"""The answer of a load spectrum: its ranges, classes and course, its damage, and how far it has converged."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wucht.dynamics.run_ups.bearing_loads import bearing_warnings, lives_of
from wucht.dynamics.run_ups.machine_signals import MachineSignal
from wucht.dynamics.run_ups.observed_loads import LoadHistory
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.errors import InputError
from wucht.fatigue.counted_cycles import RangeMeanMatrix, frequency_distance
from wucht.fatigue.damage import WoehlerLine
from wucht.fatigue.load_counting import MOST_ROWS, CountedLoad, LoadCounting
from wucht.measurements.recording import Channel
from wucht.results.formatting import decimal_text
from wucht.studies.answer import Answer
from wucht.studies.bearing_variables import state_lives

_MATRIX = 40  # classes of range and of mean
_CONVERGENCE_LIMIT = 0.05  # of the cycles, and of the damage: largest change by the second half of a converged run
_PART_OF_A_RUN = 2.0  # the first half, repeated so often, is compared with the whole
_FEWEST_SAMPLES_A_CYCLE = 10.0
_MOST_CLASSES = 10_000
_MOST_RANGES = 6  # in the report
_RESIDUES = {
    "half-cycles": "the residue counts as half cycles",
    "repeat": "the history is repeated, so that all cycles close",
    "drop": "the residue is left out",
}

Signal = MachineSignal | Channel
# What is counted, a machine's signal in a run-up or a record's; how, and the line for its damage.
Prepared = tuple[Signal, RunUpCase | None, LoadCounting, WoehlerLine | None]


def refuse_narrow_classes(values: np.ndarray, width: float | None) -> None:
    """Refuse classes so narrow that they would be too many for values (m,). Raises ``InputError``."""
    span = float(np.ptp(values)) if len(values) else 0.0
    if width is not None and span > _MOST_CLASSES * width:
        requirement = f"must be at least {span / _MOST_CLASSES:.3g}: the signal spans {span:.4g}"
        raise InputError("study.class_width", width, f"{requirement}, in {_MOST_CLASSES} classes at most")


def fill_load(prepared: Prepared, after: float | None, history: LoadHistory, a: Answer) -> None:
    """State the load so far. after: time from which it counts. Raises ``InputError`` for too narrow classes."""
    signal, case, counting, line = prepared
    time, begin = history.time, float(history.time[0]) if len(history.time) else 0.0
    begin = begin if after is None else after
    inside, middle = time >= begin, (begin + history.end_time) / 2
    values = history.values[inside]
    refuse_narrow_classes(values, counting.class_width)
    whole = counting.count(values)
    half = counting.count(values[time[inside] <= middle], whole.levels if len(whole.levels) else None)
    damages = None if line is None else [float(line.damages(load.cycles).sum()) for load in (whole, half)]
    outcome = None if history.verdict is None else str(history.verdict.outcome)
    a.failure = history.failure or _damage_overflow(whole, line, damages)
    a.attribute(signal=signal.name[:1].upper() + signal.name[1:], **({} if outcome is None else {"outcome": outcome}))
    _warn_of_run(a, prepared, history)
    _state_sentence(a, signal, whole, damages)
    end, unit_of_time = history.end_time, f" {a.unit('time')}".rstrip()
    from_to = f"from {begin:.6g} to {end:.6g}{unit_of_time}"
    a.line("signal", f"{{name}}, {from_to}", name=signal.name[:1].upper() + signal.name[1:])
    if outcome is not None:
        a.line("machine", outcome)
    a.line("counting", f"{counting.method}; {_RESIDUES[counting.residue]}")
    _state_damage(a, damages, end - begin)
    _state_spectrum(a, signal.unit, values, whole, half)
    _state_damage_by_row(a, signal.unit, whole, line)
    _state_classes(a, signal.unit, whole)
    _state_signal(a, signal, history, values, after)
    if not whole.cycles.total:
        late = "" if after is None else f" after study.after = {after:g}, and the run ends at {end:g}"
        a.warn(f"the signal has no turning points{late}: nothing was counted")
    elif counting.class_width is None and whole.class_width is not None and counting.method != "level-crossing":
        width = f"{whole.class_width:.4g} {signal.unit}".rstrip()
        classes = f"there are more than {MOST_ROWS} different ranges: the spectrum has classes of {width}"
        a.warn(f"{classes}; the damage is that of the single cycles")
    lives = {} if case is None else lives_of(case.machine, history.duties)
    state_lives(a, lives)
    a.number("counting", counting.method, "way of counting")
    a.number("residue", counting.residue, "treatment of cycles that do not close")
    a.number("begin", begin, "time from which counting starts", "time")
    a.number("half", middle, "time in the middle of the counted interval", "time")
    a.number("end", end, "time at which counting ends", "time")
    a.number("outcome", outcome, "outcome of the run-up")
    _state_convergence(a, whole, half, damages, is_judged=history.verdict is not None)
    a.warn(*bearing_warnings(lives))


def _warn_of_run(a: Answer, prepared: Prepared, history: LoadHistory) -> None:
    """Warn of what a record leaves open, or a run-up."""
    signal, case, *_ = prepared
    verdict, end = history.verdict, history.end_time
    if isinstance(signal, Channel):
        _warn_of_samples(a, signal.values)
    if case is not None:
        a.warn(*case.horizon.warnings, *case.models[0].warnings)
    if history.failure:
        a.warn(history.failure)
    if case is not None and verdict is not None:
        a.warn(*case.horizon.limit_warnings(end, verdict, case.machine.units.time))
    if verdict is not None and verdict.advice:
        a.warn(verdict.advice)


def _warn_of_samples(a: Answer, values: np.ndarray) -> None:
    """Warn where extremes fall between the samples of a record."""
    steps = np.diff(values)
    turns = int(np.count_nonzero(np.diff(np.sign(steps[steps != 0])))) if len(values) > 2 else 0
    samples_per_cycle = 2 * len(values) / turns if turns else np.inf
    if samples_per_cycle < _FEWEST_SAMPLES_A_CYCLE and len(values) >= 2 * _FEWEST_SAMPLES_A_CYCLE:
        a.warn(
            f"the record has {samples_per_cycle:.1f} samples a cycle: extremes between them are not counted, and noise is; "
            f"{_FEWEST_SAMPLES_A_CYCLE:g} samples a cycle miss up to 5 % of an amplitude. For a list of turning points this "
            "does not matter."
        )


def _state_sentence(a: Answer, signal: Signal, whole: CountedLoad, damages: Sequence[float] | None) -> None:
    if not whole.cycles.total:
        a.sentence = "there is no cycle to count"
        return
    largest = a.number_in_words(whole.cycles.largest, signal.unit)
    a.sentence = f"{whole.cycles.total:.10g} cycles, the largest of range {largest}"
    a.sentence += "" if damages is None else f"; damage {damages[0]:.4g}"


def _state_spectrum(a: Answer, unit: str, values: np.ndarray, whole: CountedLoad, half: CountedLoad) -> None:
    """State each range, or class of ranges, with mean and cycles."""
    ranges, means, counts = whole.rows.ranges, whole.rows.means, whole.rows.counts
    a.table(
        "spectrum",
        "ranges with their cycles, ascending",
        range=(ranges, "range", unit),
        mean=(means, "mean", unit),
        count=(counts, "cycles"),
    )
    if whole.cycles.total:
        low, high = (a.number_in_words(float(end), unit) for end in (values.min(), values.max()))
        a.line("between", "{low} and {high}", low=low, high=high)
        largest = sorted(zip(ranges.tolist(), means.tolist(), counts.tolist(), strict=True), key=lambda row: -row[0])
        for k, (size, mean, count) in enumerate(largest[:_MOST_RANGES]):
            cycles = f"{count:.10g} {'cycle' if count == 1 else 'cycles'}"
            place = {"size": a.number_in_words(size, unit), "mean": a.number_in_words(mean, unit)}
            a.line("" if k else "range", f"{{size}}, mean {{mean}}: {cycles}", **place)
        if len(largest) > _MOST_RANGES:
            a.line("", f"and {len(largest) - _MOST_RANGES} smaller ones")
    least = np.full(len(ranges), np.inf)  # of the cycles in each row
    np.minimum.at(least, whole.row, whole.cycles.ranges)
    twice = _PART_OF_A_RUN * half.cycles.cumulative_frequency(least)
    a.curve("range", ranges, "range", unit, "row")
    a.curve("mean", means, "mean", unit, "row")
    a.curve("count", counts, "cycles", "", "row")
    a.curve("cumulative", whole.cycles.cumulative_frequency(least), "cycles of at least this range", "", "row")
    a.curve("half_cumulative", twice, "the same, twice those of the first half", "", "row")


def _state_damage_by_row(a: Answer, unit: str, whole: CountedLoad, line: WoehlerLine | None) -> None:
    if line is not None:
        damages = np.bincount(whole.row, line.damages(whole.cycles), minlength=len(whole.rows.ranges))
        for key, value, of_key in (("k", line.k, ""), ("ND", line.ND, ""), ("SD", line.SD, unit), ("k2", line.k2, "")):
            a.curve(f"woehler_{key}", value, f"Woehler line: {key}", of_key, "")
        a.curve("damage", damages, "damage", "", "row")


def _state_classes(a: Answer, unit: str, whole: CountedLoad) -> None:
    """State the matrix of ranges and means, and the crossings of levels if they are counted."""
    matrix = RangeMeanMatrix.of(whole.cycles, _MATRIX)
    ranges, means = ((e[1:] + e[:-1]) / 2 for e in (matrix.range_edges, matrix.mean_edges))
    a.curve("range_class", ranges, "range", unit)
    a.curve("mean_class", means, "mean", unit)
    a.curve("matrix", matrix.counts, "cycles", "", "range_class mean_class")
    a.number("class_width", whole.class_width, "width of the classes of ranges, or distance of the levels", unit)
    if len(whole.levels):
        a.curve("level", whole.levels, "level", unit)
        a.curve("crossings", whole.crossings, "crossings", "", "level")
    a.number("cycles", whole.cycles.total, "number of cycles", headline=True)
    a.number("largest_range", whole.cycles.largest, "largest range", unit)


def _state_signal(a: Answer, signal: Signal, history: LoadHistory, counted_values: np.ndarray, after: float | None) -> None:
    """State the signal with its course."""
    unit = signal.unit
    least, greatest = (float(f(counted_values)) if len(counted_values) else None for f in (np.min, np.max))
    a.number("signal", signal.name, "signal that is counted")
    a.number("unit", unit, "unit of the signal")
    a.number("min", least, "smallest value", unit)
    a.number("max", greatest, "largest value", unit)
    a.number("turning_points", len(counted_values), "number of turning points")
    time, mean, low, high = history.course()
    a.curve("course_time", time, "time", "time", "part", coordinate=True)
    a.curve("lowest", low, "lowest value", unit, "part")
    a.curve("highest", high, "highest value", unit, "part")
    a.curve("average", mean, "mean value", unit, "part")
    a.curve("counted_from", after, "time from which counting starts", "time", "")


def _state_damage(a: Answer, damages: Sequence[float] | None, duration: float) -> None:
    """State Miner's sum of the whole and of its first half, and the life of the part in repetitions and in time."""
    damage = damages[0] if damages else None
    a.number("damage", damage, "Miner's sum", headline=True)
    a.line("damage", "{damage:.5g}")
    a.number("repetitions", 1 / damage if damage else None, "repetitions of this load until failure")
    life = a.number("life", duration / damage if damage else None, "life of the part under this load", "time")
    hours = f" ({decimal_text(life / 3600)} h)" if life is not None and a.unit("time") else ""
    a.line("life", f"{{repetitions:.5g}} repetitions, {{life:.5g}}{hours}")
    if damages:
        a.number("damage_of_half", damages[1], "Miner's sum of the first half")


def _damage_overflow(whole: CountedLoad, line: WoehlerLine | None, damages: Sequence[float] | None) -> str | None:
    """Return the reason why the damage is no finite number, None if it is one."""
    if line is None or damages is None or math.isfinite(damages[0]):
        return None
    times = f"{whole.cycles.largest / 2 / line.SD:.3g} times study.woehler.SD"
    return f"the damage is too large for a number: the largest amplitude is {times}; check the units of both, and the slope k"


def _state_convergence(
    a: Answer, whole: CountedLoad, half: CountedLoad, damages: Sequence[float] | None, is_judged: bool
) -> None:
    """State what the second half has changed. is_judged: that of a record, which may be any part of a load, says nothing."""
    spectrum = frequency_distance(half.cycles, whole.cycles, _PART_OF_A_RUN)
    damage = _PART_OF_A_RUN * damages[1] / damages[0] - 1 if damages and damages[0] else None
    largest_range = half.cycles.largest / whole.cycles.largest if whole.cycles.largest else None
    with a.group("convergence", "the whole compared with twice its first half"):
        a.number("spectrum", spectrum, "change of the cumulative counts, as a share of all cycles")
        a.number("largest_range", largest_range, "largest range of the first half, as a share of that of the whole")
        a.number("damage", damage, "relative change of the damage")
    if not whole.cycles.total:
        return
    change = "" if damage is None or not math.isfinite(damage) else f", and the damage by {100 * abs(damage):.2f} %"
    a.line("convergence", f"doubling the first half changes the counts by {100 * spectrum:.2f} % of all cycles{change}")
    if is_judged and max(spectrum, abs(damage or 0.0)) > _CONVERGENCE_LIMIT:
        change = "" if damage is None else f", and the damage by {100 * abs(damage):.1f} %"
        a.warn(
            f"the spectrum is not converged: from half the time to the whole the cumulative counts change by "
            f"{100 * spectrum:.1f} % of all cycles{change}; run longer, or leave out more of the run-up with study.after"
        )
