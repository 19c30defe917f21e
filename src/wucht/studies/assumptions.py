"""Assumptions of every answer in words: the equations, the speeds, and where bodies start.

The spec of a study states which equations it solves (``Spec.equations``) and whether it prescribes the speed
(``Spec.turning``); a study adds further assumptions to its answer (``results.quantities.answer``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from wucht.analysis.averaged import keeps_inertia
from wucht.dynamics.run_ups.initial_state import angles_in, initial_state, listed, speeds_in
from wucht.files.own_equations import OwnEquations
from wucht.machines.machine import Machine
from wucht.machines.operation import damped
from wucht.machines.tree import RotatingBody
from wucht.studies.spec import AVERAGED, FULL, Spec

_MODELS = {"full": FULL, "slow": AVERAGED, "both": f"{FULL} and {AVERAGED}"}
_MOST_ROTORS = 3


def assumptions(spec: Spec, subject: Any) -> list[str]:
    """The assumptions of a study of a subject, a statement each."""
    if isinstance(subject, OwnEquations):
        return ["the equations as the file gives them"]
    equations = spec.equations() or _MODELS.get(getattr(spec, "model", ""), "")
    if not isinstance(subject, Machine):
        return [equations] if equations else []
    said = [equations.replace(AVERAGED, f"{AVERAGED}{_kind_of_averaging(spec, subject)}")] if equations else []
    return [*said, spec.turning() or _turning(subject), *_starting(spec, subject)]


def _kind_of_averaging(spec: Spec, machine: Machine) -> str:
    order = " of second order" if getattr(spec, "order", 1) == 2 else ""
    if all(b.about is None for b in machine.bodies):
        return order
    given = getattr(spec, "inertia", None)
    by_default = not damped(machine) if spec.without_inertia else keeps_inertia(machine, None)
    kept = by_default if given is None else given
    return f"{order} {'with' if kept else 'without'} the inertia of the balancing bodies"


def _starting(spec: Spec, machine: Machine) -> list[str]:
    """Statements on where balancing bodies, and several rotors, start if the question does not give it."""
    if not spec.from_start:
        return []
    start: Mapping[str, Any] = getattr(spec, "start", {})
    several = [set(one) for one in getattr(spec, "starts", ())]
    named = {*start, *getattr(spec, "axes", {}), *getattr(spec, "random", {}), *(set.intersection(*several) if several else ())}
    named = {name.partition(".")[0] for name in named}
    rotors = [r for r in machine.rotors if r.name not in named and len(machine.rotors) > 1]
    silent = [b for b in machine.bodies if b.about is not None and not named & {b.name, "psi", "delta"}]
    if not silent and not rotors:
        return []
    state = initial_state(machine, start)
    angles, speeds = angles_in(machine, state), speeds_in(machine, state)
    phases = {b.name: angles[b.name] - angles[str(b.about)] for b in silent}
    said = [f"rotors start at {listed({r.name: angles[r.name] for r in rotors})}{_at_rest(rotors, speeds)}"] if rotors else []
    bodies = [f"balancing bodies start at {listed(phases)} to their rotor{_at_rest(silent, speeds)}"] if silent else []
    return [*said, *bodies]


def _at_rest(bodies: Sequence[RotatingBody], speeds: Mapping[str, float]) -> str:
    return "" if any(speeds[b.name] for b in bodies) else ", at rest"


def _turning(machine: Machine) -> str:
    """Statement on the speeds of the rotors."""
    rotors = machine.rotors
    said = [f"{r.name} {_turned(machine, r)}" for r in rotors[:_MOST_ROTORS]]
    return "; ".join([*said, *(["other rotors likewise"] if len(rotors) > _MOST_ROTORS else [])])


def _turned(machine: Machine, rotor: RotatingBody) -> str:
    if rotor.coordinate.prescribed is not None:
        return "at its given speed"
    group = {b.name for b in machine.group(rotor)}
    kinds = [d.kind for d in machine.drives if d.on in group]
    if kinds:
        return f"driven by its motor ({', '.join(kinds)})"
    return "driven with limited power" if machine.dimensionless else "without a drive"
