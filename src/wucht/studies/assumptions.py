"""Assumptions of every answer in words: the equations, the speeds, and where bodies start.

The spec of a study states which equations it solves (``Study.equations``) and whether it prescribes the speed
(``Study.turning``); a study adds further assumptions to its result (``results.quantities.result_dataset``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from wucht.analysis.averaged_equations import keeps_inertia
from wucht.dynamics.run_ups.hanging_start import hanging_words, is_hanging_start
from wucht.dynamics.run_ups.initial_state import angles_in, format_phases, initial_state, speeds_in
from wucht.files.user_system import UserSystem
from wucht.machines.machine import Machine
from wucht.machines.operation import gives_torque, has_damped_balancers
from wucht.machines.parts.track import TrackBody
from wucht.machines.tree import RotatingBody
from wucht.studies.study import AVERAGED_EQUATIONS, FULL_EQUATIONS, Study

_MODELS = {"full": FULL_EQUATIONS, "slow": AVERAGED_EQUATIONS, "both": f"{FULL_EQUATIONS} and {AVERAGED_EQUATIONS}"}
_MOST_ROTORS = 3
_VARIATIONS = ("axes", "random", "ranges")  # keys of studies whose entries differ from start to start


def assumptions(spec: Study, subject: Any) -> list[str]:
    """The assumptions of a study of a subject, a statement each."""
    if isinstance(subject, UserSystem):
        return ["the equations as the file gives them"]
    equations = spec.equations()
    if not isinstance(subject, Machine):
        return [equations] if equations else []
    equations = equations or _MODELS.get(getattr(spec, "model", ""), "")
    statements = (
        [equations.replace(AVERAGED_EQUATIONS, f"{AVERAGED_EQUATIONS}{_kind_of_averaging(spec, subject)}")] if equations else []
    )
    return [*statements, spec.turning() or _turning_statement(subject), *_start_statements(spec, subject)]


def _kind_of_averaging(spec: Study, machine: Machine) -> str:
    order = " of second order" if getattr(spec, "order", 1) == 2 else ""
    if all(b.about is None for b in machine.bodies):
        return order
    inertia = getattr(spec, "inertia", None)
    by_default = not has_damped_balancers(machine) if spec.without_inertia else keeps_inertia(machine, None)
    with_inertia = by_default if inertia is None else inertia
    return f"{order} {'with' if with_inertia else 'without'} the inertia of the balancing bodies"


def _start_statements(spec: Study, machine: Machine) -> list[str]:
    """Statements on where balancing bodies, and several rotors, start if the question does not give it."""
    if not spec.from_start:
        return []
    start: Mapping[str, Any] = getattr(spec, "start", {})
    several = [set(one) for one in getattr(spec, "starts", ())]
    varied_names = {name for key in _VARIATIONS for name in getattr(spec, key, None) or ()}
    if not varied_names - set(machine.parameters) and not several and is_hanging_start(machine, start):
        return [f"start: {hanging_words(machine)}"]
    named_bodies = {*start, *varied_names, *(set.intersection(*several) if several else ())}
    named_bodies = {name.partition(".")[0] for name in named_bodies}
    named_bodies |= {p.name for p in machine.parts if isinstance(p, TrackBody) and f"tracks.{p.track}" in varied_names}
    rotors = [r for r in machine.rotors if r.name not in named_bodies and len(machine.rotors) > 1]
    unnamed_bodies = [b for b in machine.bodies if b.about is not None and not named_bodies & {b.name, "psi", "delta"}]
    if not unnamed_bodies and not rotors:
        return []
    state = initial_state(machine, start)
    angles, speeds = angles_in(machine, state), speeds_in(machine, state)
    phases = {b.name: angles[b.name] - angles[str(b.about)] for b in unnamed_bodies}
    statements = (
        [f"rotors start at {format_phases({r.name: angles[r.name] for r in rotors})}{_rest_clause(rotors, speeds)}"]
        if rotors
        else []
    )
    bodies = (
        [f"balancing bodies start at {format_phases(phases)} relative to their rotor{_rest_clause(unnamed_bodies, speeds)}"]
        if unnamed_bodies
        else []
    )
    return [*statements, *bodies]


def _rest_clause(bodies: Sequence[RotatingBody], speeds: Mapping[str, float]) -> str:
    return "" if any(speeds[b.name] for b in bodies) else ", at rest"


def _turning_statement(machine: Machine) -> str:
    """Statement on the speeds of the rotors."""
    rotors = machine.rotors
    statements = [f"{r.name} {_drive_clause(machine, r)}" for r in rotors[:_MOST_ROTORS]]
    return "; ".join([*statements, *(["other rotors likewise"] if len(rotors) > _MOST_ROTORS else [])])


def _drive_clause(machine: Machine, rotor: RotatingBody) -> str:
    if rotor.coordinate.prescribed_velocity is not None:
        return "at its given speed"
    group = {b.name for b in machine.group(rotor)}
    kinds = [d.kind for d in machine.drives if d.on in group]
    if kinds:
        end = _end_of_drive(machine, rotor)
        until = "" if end is None else f" until {end:.5g} {machine.units.time}".rstrip() + ", then without its torque"
        return f"driven by its motor ({', '.join(kinds)}){until}"
    return "driven with limited power" if machine.dimensionless else "without a drive"


def _end_of_drive(machine: Machine, rotor: RotatingBody) -> float | None:
    """The time from which schedules leave a rotor without the torque of its drives; None where these drive it to the end."""
    end = None
    for time in reversed(machine.breakpoints if machine.schedules else ()):
        if gives_torque(machine.at(time), rotor):
            break
        end = time
    return end
