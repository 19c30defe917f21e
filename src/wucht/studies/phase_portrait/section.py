"""A machine -> a planar System: its averaged equations where two of their states are left."""

from __future__ import annotations

from dataclasses import replace

from wucht.analysis.averaged import averaged_machine, keeps_inertia
from wucht.analysis.configurations.steady_machine import turning
from wucht.analysis.sections import Section, section_of
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import damped
from wucht.studies.phase_portrait.spec import PhasePortrait


def section(spec: PhasePortrait, machine: Machine) -> Section:
    """The section that is asked for. Raises ``InputError``: not two states, or curves do not stay in it.

    Where the inertia of balancing bodies would leave more than two states, it is left out by default, with a warning.
    """
    steady = turning(machine, None)
    made = _made(spec, steady, keeps_inertia(steady, spec.inertia))
    if spec.inertia is None and made.inertia and len(made.axes) > 2 and damped(steady):
        made = _made(spec, steady, False)
        bodies = ", ".join(b.name for b in steady.bodies if b.about is not None)
        advice = "study.kind = 'approximation' shows how far such equations are from the full ones"
        left_out = (
            f"the inertia of {bodies} is left out, as if their damping were strong: with it, more states than two are left"
        )
        made = replace(made, warnings=(*made.warnings, f"{left_out}; {advice}"))
    if len(made.axes) != 2:
        _refuse(spec, made)
    return made


def _made(spec: PhasePortrait, steady: Machine, inertia: bool) -> Section:
    slow = averaged_machine(steady, inertia, spec.order, held=spec.speed is not None)
    return section_of(slow, spec.together, spec.speed)


def _refuse(spec: PhasePortrait, made: Section) -> None:
    names = made.whole.state_names
    groups = [[n for n, x in zip(names, column, strict=True) if x] for column in made.embedding.T]
    shown = ", ".join(" = ".join(group) for group in groups)
    if len(groups) < 2 and spec.together and spec.speed is not None:
        advice = "leave out speed, so that the main rotor's speed is a state, or together"
        raise InputError("study.speed", spec.speed, f"with together, one state is left, {shown}, of two: {advice}")
    if len(groups) < 2:
        raise InputError(
            "study.kind", spec.kind, f"a phase portrait has two states, and this machine's averaged equations {shown or 'none'}"
        )
    without = ", inertia = false leaves out the bodies' own speeds" if made.inertia else ""
    raise InputError(
        "study.together", spec.together,
        f"a phase portrait has two states, and these averaged equations {len(groups)}: {shown}; "
        f"together = true keeps the phases of the balancing bodies equal, speed holds the main rotor's speed{without}",
    )  # fmt: skip
