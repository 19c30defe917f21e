"""The Dataset of a response: variables over the speed, the maxima found, and the summary."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.dimensionless import natural_frequencies
from wucht.machines.forced import Forced
from wucht.machines.machine import Machine
from wucht.machines.models import Model
from wucht.machines.parts.foundation import Foundation
from wucht.machines.parts.rotor import Rotor
from wucht.machines.shaft import Shaft
from wucht.machines.vibration import free_speed, sense_of
from wucht.numerics.zeros import crossings
from wucht.results.conventions import Variable, variable
from wucht.studies.attributes import attributes
from wucht.studies.steady import left_out

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.response.study import Response

Variables = dict[str, Variable]
_NO_MOTION = 1e-9  # of the largest displacement: what moves less has no phase


@dataclass(frozen=True)
class Answered:
    """What a response finds, for a machine with its bodies at absolute angles (n,) and a range of speeds."""

    machine: Machine
    angles: np.ndarray
    range: tuple[float, float]
    points: int

    @cached_property
    def forced(self) -> Forced:
        """The vibration."""
        return Forced.of(self.machine, self.angles)

    @cached_property
    def undamped(self) -> list[float]:
        """Resonances at which the amplitude is infinite."""
        return self.forced.undamped(*self.range)

    @cached_property
    def grid(self) -> np.ndarray:
        """The speeds (N,) with the maxima among them, without those at which the amplitude is infinite."""
        coarse = self.forced.grid(*self.range, self.points)
        found = np.unique(np.concatenate([coarse, self.peak_speeds, self.torque_peak_speeds]))
        for infinite in self.undamped:
            found = found[np.abs(found - infinite) > 1e-9 * infinite]
        return found

    @cached_property
    def peak_speeds(self) -> np.ndarray:
        """Where the amplitude has a local maximum."""
        found = crossings(lambda w: self.forced.amplitude(w)[1], self.forced.grid(*self.range, self.points), -1)
        return found if self.forced.force.any() else found[:0]

    @cached_property
    def torque_peak_speeds(self) -> np.ndarray:
        """Where the torque of the vibration has a local maximum."""
        found = crossings(lambda w: self.forced.torque(w)[1], self.forced.grid(*self.range, self.points), -1)
        return found if self.forced.force.any() else found[:0]

    def amplitude_at(self, speed: float) -> float:
        """The amplitude of the axis, infinite at a resonance without damping."""
        if any(math.isclose(speed, u, rel_tol=1e-9) for u in self.undamped):
            near, far = (float(self.forced.amplitude(np.array([speed * (1 + d)]))[0][0]) for d in (1e-7, 1e-4))
            if near > 100 * far:
                return math.inf
        return float(self.forced.amplitude(np.array([speed]))[0][0])

    @cached_property
    def peaks(self) -> list[dict[str, float]]:
        """All local maxima of the amplitude in the range."""
        return [{"speed": float(w), "amplitude": self.amplitude_at(float(w))} for w in self.peak_speeds]

    @cached_property
    def torque_peaks(self) -> list[dict[str, float]]:
        """All local maxima of the vibration torque in the range."""
        at = self.torque_peak_speeds
        return [{"speed": float(w), "torque": float(t)} for w, t in zip(at, self.forced.torque(at)[0], strict=True)]

    @cached_property
    def eccentricity(self) -> float | None:
        """Of the main rotor's centre of mass; None where the axis has no motion in the plane of the rotor."""
        if self.machine.labels == ("r",):
            return None
        model = self.machine.parts[0]
        if isinstance(model, Model):  # in units of e, or of m r/M* for the self-balancing rotor, where w = m r/(M* e)
            return 1 / self.machine.values.get("w", 1.0)
        rotor = next(p for p in self.machine.parts if isinstance(p, Rotor) and p.name == self.machine.rotor.name)
        return float(rotor.moment().xreplace(self.machine.numbers)) / self.machine.values[f"{rotor.name}.mass"]

    def centre(self, speeds: np.ndarray) -> np.ndarray:
        """The distance (N,) of the main rotor's centre of mass from the axis' static position, NaN where it has none."""
        if self.eccentricity is None:
            return np.full(len(speeds), math.nan)
        angle = float(self.angles[self.machine.bodies.index(self.machine.rotor)])
        return self.forced.centre(speeds, self.eccentricity, angle)

    @cached_property
    def self_centring_speed(self) -> float | None:
        """From where to the end of the range the centre of mass stays nearer to the static position than the axis does.

        002, below (2.78). None where it never does, or where nothing is eccentric or vibrates.
        """
        if not self.eccentricity or not self.forced.force.any():
            return None
        found = crossings(lambda w: self.centre(w) - self.forced.amplitude(w)[0], self.grid)
        end = self.grid[-1:]
        inside = bool((self.centre(end) < self.forced.amplitude(end)[0])[0])
        return float(found[-1]) if inside and len(found) else None

    def losses(self, speeds: np.ndarray) -> np.ndarray:
        """The torque (N,) of loads and bearings on all shafts together, positive where it brakes."""
        found = np.zeros(len(speeds))
        for rotor in self.machine.rotors:
            sense = sense_of(self.machine, rotor)
            found += sense * Shaft.of(self.machine, rotor).losses(sense * speeds)[0]
        return found


def result(machine: Machine, question: Response, angles: np.ndarray, range_: tuple[float, float], begun: float) -> xr.Dataset:
    """Put a response into a Dataset.

    Coordinates: speed (N), direction (free coordinates of the carrier), body, mode, peak. Variables over the speed:
    displacement_real, displacement_imag (q = Re[z exp(i w t)], w t being the angle a body has turned from its start),
    displacement_amplitude, lag (direction, speed); amplitude, minor_axis, centre_distance, vibration_torque, loss_torque,
    required_torque (speed); torque_on_body (body, speed). Then eccentricity, free_speed, natural_frequency (mode),
    peak_speed, peak_amplitude (peak). begun: ``perf_counter()`` at the beginning.
    """
    import xarray as xr_

    found = Answered(machine, angles, range_, question.points)
    units, natural, free = machine.units, natural_frequencies(machine), free_speed(machine, machine.rotor)
    coordinates = {
        "speed": variable("speed", found.grid, "speed", units.speed),
        "direction": variable("direction", list(machine.free_labels), "direction"),
        "body": variable("body", [b.name for b in machine.bodies], "body"),
        "mode": variable("mode", list(natural), "mode of vibration"),
    }
    data = _vibration(found) | _torques(found)
    data |= {
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
        "free_speed": variable("", math.nan if free is None else free, "speed reached without vibration", units.speed),
        "eccentricity": variable(
            "", math.nan if found.eccentricity is None else found.eccentricity, "eccentricity of the rotor", units.length
        ),
        "peak_speed": variable("peak", found.peak_speeds, "speed of a largest amplitude", units.speed),
        "peak_amplitude": variable("peak", [p["amplitude"] for p in found.peaks], "largest amplitude", machine.orbit_unit),
    }
    dataset = xr_.Dataset(dict(data.items()), coords=coordinates)
    summary = _summary(found, dataset, natural, free)
    dataset.attrs |= attributes(machine, question, summary, summary["sentence"], _warnings(found), begun)
    return dataset


def _vibration(found: Answered) -> Variables:
    machine, units, speeds = found.machine, found.machine.units, found.grid
    z = found.forced.displacement(speeds)[0].T
    return {
        "displacement_real": variable("direction speed", z.real, "displacement at the start of a turn (r: rad)", units.length),
        "displacement_imag": variable("direction speed", z.imag, "displacement a quarter turn before (r: rad)", units.length),
        "displacement_amplitude": variable("direction speed", np.abs(z), "amplitude of the carrier (r: rad)", units.length),
        "lag": variable("direction speed", _lag(found, z), "phase lag behind the unbalance", "rad"),
        "amplitude": variable("speed", found.forced.amplitude(speeds)[0], "amplitude of the axis", machine.orbit_unit),
        "minor_axis": variable("speed", found.forced.minor(speeds), "semi-minor axis of the orbit", machine.orbit_unit),
        "centre_distance": variable("speed", found.centre(speeds), "distance of the centre of mass", units.length),
    }


def _lag(found: Answered, z: np.ndarray) -> np.ndarray:
    """By which angle (m, N) each displacement comes after the force of the unbalance in its direction.

    A foundation, on which no unbalance acts, after that of the direction which it carries; anything else on which the
    unbalances exert no force after the main rotor's angle. NaN for what does not move.
    """
    machine, force = found.machine, found.forced.force
    main = np.exp(1j * found.forced.phases[machine.bodies.index(machine.rotor)])
    by_label = dict(zip(machine.free_labels, force, strict=True))
    foundation = next((f for p in machine.parts if isinstance(f := getattr(p, "foundation", None), Foundation)), None)
    if foundation is not None:
        by_label["foundation"] = by_label.get(foundation.direction, 0.0)
    behind = np.array([by_label[label] or main for label in machine.free_labels])
    lag: np.ndarray = np.mod(-np.angle(z / behind[:, None]), 2 * math.pi)
    lag[lag > 2 * math.pi - 1e-9] = 0.0
    size = np.abs(z).max(axis=1)
    lag[size <= _NO_MOTION * size.max(initial=0.0)] = math.nan
    return lag


def _torques(found: Answered) -> Variables:
    unit, speeds, forced = found.machine.units.torque, found.grid, found.forced
    vibration, losses = forced.torque(speeds)[0], found.losses(speeds)
    on = [forced.torque_on(speeds, [i])[0] for i in range(len(found.machine.bodies))]
    return {
        "vibration_torque": variable("speed", vibration, "torque of the vibration", unit),
        "loss_torque": variable("speed", losses, "torque of loads and bearings", unit),
        "required_torque": variable("speed", vibration + losses, "torque required", unit),
        "torque_on_body": variable("body speed", on, "torque of the vibration on a body", unit),
    }


def _summary(found: Answered, dataset: xr.Dataset, natural: dict[str, float], free: float | None) -> dict[str, Any]:
    low, high = found.range
    critical: list[float] = []
    for f in sorted(natural.values()):
        if low <= f <= high and f > 0 and not (critical and math.isclose(critical[-1], f, rel_tol=1e-9)):
            critical.append(f)
    speeds, amplitude, torque = found.grid, dataset.amplitude.values, dataset.vibration_torque.values
    largest, hardest = int(amplitude.argmax()), int(torque.argmax())
    peak, at = float(amplitude[largest]), float(speeds[largest])
    infinite = [p for p in found.peaks if math.isinf(p["amplitude"])]
    if infinite:
        peak, at = math.inf, infinite[-1]["speed"]
    summary = {
        "range": [low, high],
        "critical_speeds": critical,
        "natural_frequencies": natural,
        "peak_amplitude": peak,
        "peak_speed": at if peak else None,
        "peaks": found.peaks,
        "peak_torque": float(torque[hardest]),
        "peak_torque_speed": float(speeds[hardest]) if torque[hardest] > 0 else None,
        "torque_peaks": found.torque_peaks,
        "free_speed": free,
        "amplitude_at_free_speed": None if free is None else found.amplitude_at(abs(free)),
        "eccentricity": found.eccentricity,
        "self_centring_speed": found.self_centring_speed,
    }
    return {"sentence": _sentence(found, summary)} | summary


def _sentence(found: Answered, summary: dict[str, Any]) -> str:
    count, free = len(summary["critical_speeds"]), summary["free_speed"]
    if not found.forced.force.any():
        return "nothing excites the carrier: the unbalances are zero or cancel"
    said = f"{count or 'no'} critical speed{'' if count == 1 else 's'} in the range"
    if free and summary["critical_speeds"]:
        below = sum(c < abs(free) for c in summary["critical_speeds"])
        where = "above" if below == count else "below" if not below else "between"
        said += f"; the drive runs {where} {'it' if count == 1 else 'them'}"
    return said


def _warnings(found: Answered) -> list[str]:
    machine, said = found.machine, []
    for speed in found.undamped:
        said.append(f"nothing damps the resonance at {speed:.6g}{_unit(machine)}: there the amplitude is infinite")
    return said + left_out(machine)


def _unit(machine: Machine) -> str:
    return f" {machine.units.speed}" if machine.units.speed else ""
