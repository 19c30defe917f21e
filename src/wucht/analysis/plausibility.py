"""Plausibility of a vibratory machine: numbers that are far from what screens and conveyors have in practice.

A machine is taken for one where exciters drive a carrier that translates: two or more driven rotors about which no body
turns, or one whose unbalance is that of an exciter's data sheet. Practice: acceleration 2 to 9 times that of gravity, over all
processes from fluidised beds to sieving, stroke 2 e = 2 m r/M, speed of the exciters 3 to 5 times the natural
frequency of the support (Italvibras, catalogue of electric vibrators, pages 96 to 98, choice of vibrator and mounts); strokes
of 2 to 12 mm. Damping ratios are below 0.01 of steel springs and up to 0.15 of rubber (C. M. Harris, A. G. Piersol, Harris'
Shock and Vibration Handbook, chapters on isolators).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from wucht.analysis.throw import GRAVITY
from wucht.analysis.vibration import unbalances
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.machines.parts.rotor import Rotor

_LEAST_G, _MOST_G = 1.0, 12.0  # machine number: below, nothing is moved on it; above, a third beyond practice
_STROKES = 1e-3, 15e-3  # m
_MOST_DAMPING = 0.3


def plausibility_notes(machine: Machine) -> tuple[str, ...]:
    """Return sentences on numbers of a vibratory machine that are far from practice; none for other machines.

    The motion is that far above the natural frequencies, all exciters in phase: a = sum of m r over the mass that vibrates.
    """
    if machine.dimensionless or not {"x", "y"} & set(machine.free_labels):
        return ()
    machine = machine.at(machine.breakpoints[-1])
    exciters = _exciters(machine)
    speeds = [abs(speed) for r in machine.rotors if r.name in exciters and (speed := free_speed(machine, r))]
    return tuple(_doubts(machine, exciters, max(speeds))) if speeds else ()


def _exciters(machine: Machine) -> dict[str, Rotor]:
    """The driven rotors with an unbalance about which nothing turns, by name, if they shake the carrier on purpose."""
    carrying, driven = {b.about for b in machine.bodies}, {d.on for d in machine.drives}
    exciters = {p.name: p for p in machine.parts if isinstance(p, Rotor) and p.name in driven - carrying}
    return exciters if len(exciters) > 1 or any(p.origin for p in exciters.values()) else {}


def _doubts(machine: Machine, exciters: dict[str, Rotor], speed: float) -> Iterator[str]:
    mass = float(machine.matrices[0][0, 0])
    of_bodies = zip(machine.bodies, np.abs(unbalances(machine)), strict=True)
    amplitude = sum(float(u) for body, u in of_bodies if body.name in exciters) / mass
    stroke, number, rpm = 2 * amplitude, amplitude * speed**2 / GRAVITY, 30 / math.pi
    if number < _LEAST_G:
        return
    if number > _MOST_G or not _STROKES[0] <= stroke <= _STROKES[1]:
        of_all = (
            f"stroke {1e3 * stroke:.3g} mm and machine number {number:.3g} at {speed * rpm:.4g} rpm, of all exciters in phase"
        )
        twice = number > _MOST_G and not any(p.origin for p in exciters.values())
        yield f"far from practice: {of_all}; screens have 2 to 12 mm and 3 to 9{_TWICE if twice else ''}"
    highest = max(w for w in natural_frequencies(machine).values() if math.isfinite(w))
    if highest > speed:
        above = f"above the {speed * rpm:.4g} rpm of the exciters; that of a screen is a third to a fifth of its speed"
        yield f"far from practice: a natural frequency of the support is {highest * rpm:.4g} rpm, {above}"
    for direction in (d for d in machine.free_labels if d in ("x", "y")):
        stiffness, damping = (_of_the_support(machine, key, direction) for key in ("stiffness", "damping"))
        ratio = damping / (2 * math.sqrt(stiffness * mass)) if stiffness else 0.0
        if ratio > _MOST_DAMPING:
            usual = "that of steel springs is below 0.01, of rubber up to 0.15"
            yield f"far from practice: the damping ratio of the mounts in {direction} is {ratio:.2g}; {usual}"


def _of_the_support(machine: Machine, key: str, direction: str) -> float:
    """The stiffness or damping of all mounts together in a direction; that of attachments is not counted."""
    paths = re.compile(rf"carrier\.(mounts\.\d+\.)?{key}(\.{direction})?")
    return sum(value for path, value in machine.values.items() if paths.fullmatch(path))


_TWICE = ". A data sheet may state the working moment 2 m r, twice the unbalance: write working_moment"
