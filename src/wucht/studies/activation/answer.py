"""The answer of an activation: its runs, groups of them over the phases, and the best of these."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any

import numpy as np

from wucht.analysis.switching import Switching, switchable, switching
from wucht.dynamics.sampling.choice import Scores, nearest_cliff, sides_on_grid
from wucht.machines.machine import Machine
from wucht.machines.operation import natural_frequencies
from wucht.studies.activation.activation_runs import (
    BALANCED_VARIANT,
    CURVE,
    NO_PENDULUMS,
    RIGID,
    SWITCHABLE,
    ActivationCase,
    ActivationRun,
)
from wucht.studies.answer import Answer

_RESIDUAL_LIMIT = 1e-6  # a larger energy residual is reported as a warning
_AXES = ("activation_speed", "orientation")
Cell = tuple[str, int, int, int]  # variant, and the indices of activation speed, orientation and phase, -1 without one
Group = dict[str, Any]
Switchings = Sequence[tuple[Switching, ...]]  # of each pendulum, at each activation speed


def state_activation(
    machine: Machine, orientations: Sequence[float], phases: Sequence[float],
    prepared: tuple[Sequence[ActivationCase], Switchings], runs: Sequence[ActivationRun], a: Answer,
) -> None:  # fmt: skip
    """State the runs so far, with NaN where one is missing. orientations, phases: of the pendulums at the start."""
    cases, switchings = prepared
    results = {case.cell: run for case, run in zip(cases, runs, strict=False)}
    bare_run = results.get((NO_PENDULUMS, -1, -1, -1))
    speeds, machine_speed = [s[0].opening for s in switchings], switching(machine, switchable(machine)[0]).opening
    groups = {
        SWITCHABLE: _groups(orientations, len(phases), results, SWITCHABLE, speeds),
        BALANCED_VARIANT: _groups(orientations, len(phases), results, BALANCED_VARIANT, [machine_speed]),
        RIGID: _groups(orientations, len(phases), results, RIGID, [None]),
    }
    worst = max((run.energy_residual for run in runs), default=None)
    _state_groups(a, machine, groups, bare_run)
    _state_pendulums(a, machine, switchings)
    a.number("natural_frequencies", natural_frequencies(machine), "natural frequencies by mode", "speed")
    a.number("energy_residual", worst, "largest energy residual")
    a.number("runs", len(results), "number of completed runs")
    _state_runs(a, machine, results, speeds, orientations, phases)
    peak = bare_run and bare_run.peak
    a.curve("none_peak", peak, "largest amplitude without pendulums", machine.orbit_unit, "")
    a.line("none", "{none.peak_amplitude} at {none.peak_speed}")
    _state_curves(a, machine, results, orientations)
    for of in (RIGID, BALANCED_VARIANT, SWITCHABLE):
        for k, group in enumerate(groups[of]):
            after = "" if of == RIGID else ", none opens"
            if group.get("peak_after") is not None:
                after = ", {peak_after} from the opening on"
            at = "at {activation_speed}, " if of != RIGID and len(switchings) > 1 else ""
            outcomes = ", ".join(f"{n} {outcome}" for outcome, n in group["outcomes"].items())
            a.line(of, f"{at}{{orientation}} apart: {{peak_amplitude}} at most{after}; {outcomes}", at=f"{of}[{k}]")
    a.line("energy", "balance closed to {energy_residual:.1e} in all runs")
    a.failure = next((run.failure for run in runs if run.failure), None)
    a.sentence = _sentence(groups, bare_run, *((1e3, "mm") if machine.orbit_unit == "m" else (1.0, machine.orbit_unit)))
    closed_runs = sum(not all(run.open_at_end) for (of, *_), run in results.items() if of in (SWITCHABLE, BALANCED_VARIANT))
    if closed_runs:
        a.warn(f"in {closed_runs} runs not all pendulums are open at the end")
    if worst is not None and not worst <= _RESIDUAL_LIMIT:
        a.warn(f"the energy balance closes only to {worst:.1e}: give a smaller study.tolerance")
    if missing := len(cases) - len(results):
        a.warn(f"{missing} of {len(cases)} runs are missing")


def _words(a: Answer, machine: Machine) -> dict[str, tuple[str, str]]:
    """Names in words and units of the numbers of runs and of groups of runs."""
    length, speed = machine.orbit_unit, a.unit("speed")
    return {
        "activation_speed": ("activation speed", speed),
        "orientation": ("orientation at the start", "rad"),
        "peak": ("largest amplitude", length),
        "peak_before": ("largest amplitude before the first opening", length),
        "peak_after": ("largest amplitude from the first opening on", length),
        "peak_amplitude": ("largest amplitude", length),
        "peak_speed": ("mean speed of the rotor over the turn there", speed),
        "mean_peak": ("mean of the largest amplitudes", length),
        "final_amplitude": ("amplitude at the end", length),
        "opened_at": ("mean speed of the pendulums as they open", speed),
        "orientations_at_activation": ("angles between the first two as one opens", "rad"),
        "all_open": ("number of runs at whose end all are open", ""),
        "energy_residual": ("energy residual, relative", ""),
        "neighbours": ("groups beside it", ""),
        "cliff": ("nearest value at which the largest amplitude is more than twice as large", ""),
        "outcome": ("outcome", ""),
        "outcomes": ("number of runs of each outcome", ""),
    }


def _state_runs(
    a: Answer, machine: Machine, results: dict[Cell, ActivationRun],
    speeds: Sequence[float], orientations: Sequence[float], phases: Sequence[float],
) -> None:  # fmt: skip
    """State each run at its activation speed, orientation and phase."""
    length, every, words = machine.orbit_unit, "activation_speed orientation phase", _words(a, machine)

    def run_array(reading: Callable[[ActivationRun], Any], of: str = SWITCHABLE, kind: type | str = float) -> np.ndarray:
        """Array of a reading of each run (speeds, orientations, phases)."""
        shape = len(speeds) if of == SWITCHABLE else 1, len(orientations), len(phases)
        values = np.full(shape, math.nan if kind is float else "", kind)
        for (_, i, j, k), run in ((cell, run) for cell, run in results.items() if cell[0] == of):
            values[max(i, 0), j, k] = reading(run)
        return values

    a.curve("activation_speed", list(speeds), *words["activation_speed"])
    a.curve("orientation", list(orientations), *words["orientation"])
    a.curve("phase", list(phases), "mean phase at the start", "rad")
    for name in ("peak", "peak_before", "peak_after", "final_amplitude", "energy_residual"):
        a.curve(name, run_array(attrgetter(name)), *words[name], every)
    a.curve("opened_at", run_array(lambda run: np.mean(run.opened_at)), *words["opened_at"], every)
    separation = run_array(attrgetter("orientation"))
    a.curve("orientation_at_activation", separation, "angle between the first two as one opens", "rad", every)
    a.curve("outcome", run_array(attrgetter("outcome"), kind="U24"), "outcome", "", every)
    balanced_peak, rigid_peak = (run_array(attrgetter("peak"), of)[0] for of in (BALANCED_VARIANT, RIGID))
    at = "orientation phase"
    a.curve("balanced_peak", balanced_peak, "largest amplitude without permanent unbalances", length, at)
    a.curve("rigid_peak", rigid_peak, "largest amplitude, rigid pendulums", length, at)


def _state_curves(a: Answer, machine: Machine, results: dict[Cell, ActivationRun], orientations: Sequence[float]) -> None:
    """State curves without pendulums, and of the first phase of each orientation at the first activation speed."""
    curves = {"without pendulums": results[NO_PENDULUMS, -1, -1, -1].curve} if (NO_PENDULUMS, -1, -1, -1) in results else {}
    for of, i in ((SWITCHABLE, 0), (BALANCED_VARIANT, -1), (RIGID, -1)):
        for j, angle in enumerate(orientations):
            if (of, i, j, 0) in results:
                curves[f"{of}, {math.degrees(angle):.4g}\u00b0"] = results[of, i, j, 0].curve
    values = np.array([*curves.values()]).reshape(len(curves), 2, CURVE)
    a.curve("curve", list(curves) or np.empty(0, "U1"), "run")
    a.curve("curve_speed", values[:, 0], "speed of the rotor", "speed", "curve point")
    a.curve("curve_amplitude", values[:, 1], "amplitude of the axis", machine.orbit_unit, "curve point")


def _state_groups(a: Answer, machine: Machine, groups: dict[str, list[Group]], bare_run: ActivationRun | None) -> None:
    """State numbers over the runs of all phases, of each variant."""
    words = _words(a, machine)
    for of, rows in groups.items():
        a.number(of, rows, f"{of} pendulums by their orientation", parts=words)
    run = bare_run and {
        "peak_amplitude": bare_run.peak,
        "peak_speed": None if math.isnan(bare_run.peak_speed) else bare_run.peak_speed,
        "outcome": bare_run.outcome,
    }
    a.number("none", run, "machine without pendulums", parts=words)
    best = _best_group(groups[SWITCHABLE])
    a.number("best", best, "switchable pendulums whose largest amplitude is smallest", parts=words)


def _best_group(groups: list[Group]) -> Group | None:
    """The group with the smallest peak, those beside it, and the nearest value at which the peak is twice as large."""
    if not groups:
        return None
    peaks = np.array([[float(g["peak_amplitude"])] for g in groups])
    values = np.array([[g[name] for name in _AXES] for g in groups], float)
    scores = Scores(peaks, np.zeros(peaks.shape, bool))
    k = int(scores.order[0])
    sides = sides_on_grid(values, k)
    cliff = nearest_cliff(scores, k, _AXES, values, sides)
    nearest = [groups[beside[0]] for _, beside in sides if beside]
    return groups[k] | {
        "neighbours": [{name: g[name] for name in (*_AXES, "peak_amplitude")} for g in nearest],
        "cliff": None if cliff is None else {
            "parameter": cliff.parameter, "value": cliff.value, "inside": cliff.inside, "peak_amplitude": cliff.cost
        },
    }  # fmt: skip


def _groups(
    orientations: Sequence[float], count: int, results: dict[Cell, ActivationRun], of: str, openings: Sequence[float | None]
) -> list[Group]:
    """Return the groups of a variant, for each activation speed and orientation with completed runs. count: of phases."""
    groups = list[Group]()
    for i, opening in enumerate(openings):
        for j, orientation in enumerate(orientations):
            cells = [(of, i if of == SWITCHABLE else -1, j, k) for k in range(count)]
            if runs := [results[cell] for cell in cells if cell in results]:
                groups.append(_group(runs, orientation, opening))
    return groups


def _group(runs: Sequence[ActivationRun], orientation: float, opening: float | None) -> Group:
    """Return numbers over the runs of all phases. opening: the activation speed, None of rigid pendulums."""
    peaks = [run.peak for run in runs]
    group: Group = {
        "orientation": orientation,
        "peak_amplitude": max(peaks),
        "mean_peak": float(np.mean(peaks)),
        "outcomes": dict(Counter(run.outcome for run in runs)),
    }
    if opening is None:
        return group
    opening_runs = [run for run in runs if not math.isnan(run.peak_after)]
    return group | {
        "activation_speed": opening,
        "peak_before": max((run.peak_before for run in opening_runs), default=None),
        "peak_after": max((run.peak_after for run in opening_runs), default=None),
        "opened_at": float(np.nanmean([run.opened_at for run in opening_runs])) if opening_runs else None,
        "orientations_at_activation": [None if math.isnan(run.orientation) else run.orientation for run in runs],
        "all_open": sum(all(run.open_at_end) for run in runs),
    }


def _state_pendulums(a: Answer, machine: Machine, switchings: Switchings) -> None:
    """State the speeds at which each pendulum opens and closes, at each activation speed."""
    names = [p.name for p in switchable(machine)]
    of_pendulums = list(zip(*switchings, strict=True))

    def column(name: str) -> list[list[Any]]:
        return [[getattr(s, name) for s in of_pendulum] for of_pendulum in of_pendulums]

    a.table(
        "pendulums", "switchable pendulums",
        name=(names, "name of the pendulum"),
        opening=(column("opening"), "speeds at which it opens", "speed"),
        closing=(column("closing"), "speeds at which it closes", "speed"),
        after_opening=(column("open_speed"), "speeds at which it continues once it is open", "speed"),
        snaps=(column("snaps"), "whether its mass goes from stop to stop"),
        stays_open=(column("stays_open"), "whether it then remains open"),
    )  # fmt: skip
    alike: dict[str, list[str]] = {}
    for name, of_pendulum in zip(names, of_pendulums, strict=True):
        for s in of_pendulum:
            opens, closes = (a.number_in_words(w, "speed") for w in (s.opening, s.closing))
            behaviour = f"opens at {opens}, closes at {closes}{'' if s.snaps else ': gradually in between'}"
            alike.setdefault(behaviour, []).append(name)
            if s.snaps and not s.stays_open:
                slower = f"as its mass moves out the speed falls to {a.number_in_words(s.open_speed, 'speed')}"
                cure = "more frame inertia, less stiffness or a shorter stroke keep it open"
                closing = f"and it closes below {closes}; {cure}"
                a.warn(f"{name!r} may open and close repeatedly: {slower}, {closing}")
    for behaviour, pendulums in alike.items():
        a.line(", ".join(pendulums), behaviour)


def _sentence(groups: dict[str, list[Group]], bare_run: ActivationRun | None, scale: float, unit: str) -> str:
    names = {SWITCHABLE: "switchable pendulums", BALANCED_VARIANT: "balanced ones", RIGID: "rigid ones"}
    peaks = {name: [scale * g["peak_amplitude"] for g in groups[of]] for of, name in names.items() if groups[of]}
    ends = {name: dict.fromkeys((f"{min(p):.4g}", f"{max(p):.4g}")) for name, p in peaks.items()}
    texts = [f"{name} {' to '.join(limits)} {unit}" for name, limits in ends.items()]
    texts += [f"none {scale * bare_run.peak:.4g} {unit}"] if bare_run else []
    return f"peak with {', '.join(texts)}" if texts else "no run is finished"
