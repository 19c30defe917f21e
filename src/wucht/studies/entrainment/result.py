"""The Dataset of the study ``entrainment``: phases and speeds over the parameter, the bands, and the summary."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.machines.vibration import free_speed
from wucht.results.conventions import Variable, variable
from wucht.results.conventions import wrapped as in_a_turn
from wucht.results.outcomes import Outcome
from wucht.studies.attributes import attributes
from wucht.studies.entrainment.along import Along
from wucht.studies.entrainment.kept import kept
from wucht.studies.resuming import fingerprint

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.entrainment.search import Record
    from wucht.studies.entrainment.study import Entrainment


def result(machine: Machine, question: Entrainment, along: Along, record: Record, begun: float) -> xr.Dataset:
    """Put what was found into a Dataset.

    Coordinate: body, those that have a phase: to the rotor that they turn about, of a rotor to the main one, of the main rotor
    to the vibration (then in (-pi, pi], else in [0, 2 pi)). Of the slow equations (point): value, phase (body, point), speed,
    stable, branch. Of periodic motions of the full ones (orbit): orbit_value, orbit_phase, orbit_speed, orbit_stable,
    orbit_multiplier (the largest that is not 1 for reasons of form). Of runs from the start (run): as in
    ``kept``, and free_speed of the main rotor. begun: ``perf_counter()`` at the beginning.
    """
    import xarray as xr_

    names = _names(machine, record)
    runs = record.runs or ([] if record.own is None else [record.own])
    free = [free_speed(along.at(machine, r.value).at(machine.corners[-1]), machine.rotor, machine.corners[-1]) for r in runs]
    alone = np.array([math.nan if f is None else f for f in free])
    dataset = xr_.Dataset(
        _of_slow(machine, along, record, names)
        | _of_orbits(machine, along, record, names)
        | kept(machine, along, runs)
        | {"free_speed": variable("run", alone, "speed without vibration", machine.units.speed)},
        coords={"body": variable("body", names or np.empty(0, "U1"), "body")},
    )
    summary = _summary(machine, question, along, record, names)
    dataset.attrs |= attributes(
        machine, question, summary, summary["sentence"], [*record.warnings, *_warnings(along, record)], begun,
        record.failure, record.interrupted,
    )  # fmt: skip
    dataset.attrs |= {
        "asked": asked(machine, question),
        "along": along.name,
        "along_unit": along.unit,
        "along_what": along.what,
    }
    dataset.attrs |= {"frequency": machine.values["carrier.motion.frequency"]} if machine.shaken is not None else {}
    return dataset


def _of_slow(machine: Machine, along: Along, record: Record, names: list[str]) -> dict[str, Variable]:
    branches = record.branches
    states = np.concatenate([b.states for b in branches], axis=1) if branches else np.empty((0, 0))
    count = states.shape[1] if branches else 0
    phases, speeds = np.full((len(names), count), np.nan), np.full(count, np.nan)
    if record.slow is not None and branches:
        rows = {n: states[record.slow.names.index(f"{n}.phase")] for n in record.slow.phase_names}
        phases = np.array([wrapped(machine, rows[n]) if n in rows else np.full(count, np.nan) for n in names])
        speeds = record.slow.speed(states)
    numbers = _joined([np.full(len(b.values), k) for k, b in enumerate(branches)]).astype(int)
    return {
        "value": variable("point", _joined([b.values for b in branches]), along.what, along.unit),
        "phase": variable("body point", phases, "phase", _angle_unit(machine)),
        "speed": variable("point", speeds, "speed", machine.units.speed),
        "stable": variable("point", _joined([b.stable for b in branches]).astype(np.int8), "stable"),
        "branch": variable("point", numbers, "branch"),
    }


def _of_orbits(machine: Machine, along: Along, record: Record, names: list[str]) -> dict[str, Variable]:
    orbits = record.orbits
    turned = [wrapped(machine, _ordered(o.phases, record.names, names)) for o in orbits]
    phases = np.array(turned).reshape(len(orbits), len(names)).T
    return {
        "orbit_value": variable("orbit", np.array([o.value for o in orbits]), along.what, along.unit),
        "orbit_phase": variable("body orbit", phases, "phase", _angle_unit(machine)),
        "orbit_speed": variable("orbit", np.array([o.speed for o in orbits]), "speed", machine.units.speed),
        "orbit_stable": variable("orbit", np.array([o.stable for o in orbits], np.int8), "stable"),
        "orbit_multiplier": variable("orbit", np.array([o.multiplier for o in orbits]), "largest multiplier"),
    }


def _angle_unit(machine: Machine) -> str:
    return "rad" if machine.units.time else ""


def asked(machine: Machine, question: Entrainment) -> str:
    """What an interrupted study must agree in to be gone on with: the runs depend on nothing else."""
    return fingerprint(machine, [question.along, dict(question.start), question.until])


def wrapped(machine: Machine, phases: np.ndarray) -> np.ndarray:
    """Phases to a vibration in (-pi, pi], as 001 (22) has them, to a rotor in [0, 2 pi)."""
    return math.pi - in_a_turn(math.pi - phases) if machine.shaken is not None else in_a_turn(phases)


def _names(machine: Machine, record: Record) -> list[str]:
    if record.names:
        return record.names
    return [b.name for b in machine.bodies if machine.shaken is not None or b is not machine.rotor]


def _ordered(values: np.ndarray, have: list[str], want: list[str]) -> np.ndarray:
    return np.array([values[have.index(n)] for n in want])


def _joined(parts: list[np.ndarray]) -> np.ndarray:
    return np.concatenate(parts) if parts else np.empty(0)


def _summary(machine: Machine, question: Entrainment, along: Along, record: Record, names: list[str]) -> dict[str, Any]:
    own, orbit, chosen = record.own, record.own_orbit, record.chosen
    phases = (
        dict(zip(names, wrapped(machine, _ordered(orbit.phases, record.names, names)).tolist(), strict=True)) if orbit else {}
    )
    if not phases and own is not None and own.taken:
        found = own.phases
        phases = {names[0]: float(wrapped(machine, np.array(found["vibration"])))} if "vibration" in found else dict(found)
    slow = _slow_phases(machine, along, record)
    mean = None if own is None else own.mean_speed
    if orbit is not None and own is not None:
        mean = math.copysign(orbit.speed, own.mean_speed)
    band, ends = record.band, record.ends
    return {
        "sentence": _sentence(machine, along, record),
        "outcome": str(_outcome(machine, record)),
        "along": along.name,
        "along_unit": along.unit,
        "value": along.own,
        "range": None if record.range is None else list(record.range),
        "existence_band": None
        if chosen is None
        else [None if e.kind == "range" else e.value for e in (chosen.low, chosen.high)],
        "existence_band_from": None if chosen is None else "slow equations",
        "existence_edges": None if chosen is None else [chosen.low.kind, chosen.high.kind],
        "branch": None if chosen is None else chosen.branch,
        "existence_band_full": list(ends) if record.orbits else None,
        "band_from_rest": None if band is None else [band.low, band.high],
        "islands": [] if band is None else [list(i) for i in band.islands],
        "phase": _one(phases),
        "phases": phases,
        "phase_slow": _one(slow),
        "phases_slow": slow,
        "mean_speed": mean,
        "window": None if own is None else list(own.window),
        "stable": None if orbit is None else orbit.stable,
        "multiplier": None if orbit is None else orbit.multiplier,
        "threshold_amplitude": record.threshold,
        "resolution": record.resolution,
    }


def _one(phases: dict[str, float]) -> float | dict[str, float] | None:
    """The phase where there is one, else all by name; None where there is none."""
    return next(iter(phases.values())) if len(phases) == 1 else phases or None


def _slow_phases(machine: Machine, along: Along, record: Record) -> dict[str, float]:
    slow, chosen, state = record.slow, record.chosen, record.equilibrium
    if slow is None or chosen is None or state is None or not chosen.low.value < along.own < chosen.high.value:
        return {}
    return {n: float(wrapped(machine, state[slow.names.index(f"{n}.phase")])) for n in slow.phase_names}


def _outcome(machine: Machine, record: Record) -> Outcome:
    if record.failure is not None or record.own is None:
        return Outcome.FAILED if record.failure is not None else Outcome.UNIDENTIFIED
    if machine.shaken is not None:
        return Outcome.ENTRAINED if record.own.taken else Outcome.NOT_ENTRAINED
    return Outcome.SYNCHRONISED if record.own.taken else Outcome.NOT_SYNCHRONISED


def _sentence(machine: Machine, along: Along, record: Record) -> str:
    if record.failure is not None:
        return record.failure
    said = _outcome(machine, record).sentence
    if record.interrupted:
        return f"{said}; the study was interrupted before its band was found"
    if record.band is None:
        return f"{said}; nowhere in the range is it reached from the start"
    unit = f" {along.unit}" if along.unit else ""
    low, high = record.band.low, record.band.high
    if low is not None and high is not None:
        return f"{said}; from the start that is reached between {along.name} = {low:.6g} and {high:.6g}{unit}"
    if low is None and high is None:
        return f"{said}; from the start that is reached in all of the range"
    side, edge = ("below", high) if low is None else ("above", low)
    return f"{said}; from the start that is reached {side} {along.name} = {edge:.6g}{unit}"


def _warnings(along: Along, record: Record) -> list[str]:
    said = []
    if record.interrupted:
        said.append(f"interrupted after {len(record.runs)} runs from the start; --resume goes on")
    unit = f" {along.unit}" if along.unit else ""
    if record.band is not None and record.band.islands:
        where = ", ".join(f"{low:.5g} to {high:.5g}" for low, high in record.band.islands)
        said.append(f"from the start it is also reached apart from the band: {where}{unit}; finer points may show more")
    undecided = [r.value for r in record.runs if r.taken and r.drift > 0.02]
    if undecided:
        said.append(
            f"at {along.name} = {undecided[0]:.6g}{unit} the phase still moves at the end of the run: give a longer until"
        )
    return said
