"""The load of motors in an answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wucht.dynamics.run_ups.motor_loads import MotorLoad, StartLoad, torque_share
from wucht.machines.machine import Machine
from wucht.studies.answer import Answer

_MOST = 4  # motors named one by one


def state_motor_loads(a: Answer, loads: Mapping[str, MotorLoad], mark: str = "") -> None:
    """State the load of motors whose rated data are known, by the body that they drive, with lines on it."""
    if not loads:
        return
    torques, powers = ({on: getattr(load, name) for on, load in loads.items()} for name in ("torque_share", "power_share"))
    a.number("motor_load", torques, "mean torque of each motor at the end over its rated one")
    a.number("motor_power_share", powers, "mean power of each motor at the end over its rated one")
    first = sorted(loads, key=lambda on: -torques[on])[:_MOST]
    in_operation = ", ".join(f"{on} {100 * torques[on]:.3g} %" for on in loads if on in first)
    starts = {on: load.start for on, load in loads.items() if load.start is not None}
    over_start = ", ".join(f"{on} {100 * start.share:.3g} %" for on, start in starts.items() if on in first)
    at_start = f"; {over_start} (rms) over the start" if over_start else ""
    a.line("motors", "{loads}", loads=f"{in_operation} of the rated torque in operation{at_start}{mark}")
    if starts:
        _state_starts(a, starts, first)


def _state_starts(a: Answer, starts: Mapping[str, StartLoad], first: Sequence[str]) -> None:
    """State torque and heat of motors over a start. first: those that are named."""
    what = "root mean square of the torque of each motor over the start"
    a.number("starting_rms_torque", {on: start.torque for on, start in starts.items()}, what, "N m")
    a.number("starting_rms_share", {on: start.share for on, start in starts.items()}, f"{what}, over its rated one")
    heats = {on: start.heat for on, start in starts.items() if start.heat is not None}
    if not heats:
        return
    a.number("starting_heat", heats, "I^2 t of each motor over the start, in units of its rated current squared", "s")
    what = "fastest trip class of an overload relay that lets the start of each motor pass, IEC 60947-4-1"
    classes = a.number("trip_class", {on: starts[on].trip_class for on in heats}, what)
    texts = [f"{on} {heat:.3g} s, {_class_in_words(classes[on])}" for on, heat in heats.items() if on in first]
    a.line("start", "{heats}", heats=f"I\u00b2t over that of the rated current: {'; '.join(texts)}")


def state_motor_shares(a: Answer, machine: Machine, rotor: str, speed: float | None) -> None:
    """State the load of the motors of a rotor at its operating speed, if there is one and their rated data are known."""
    motors = [] if speed is None else [d for d in machine.drives if d.on == rotor]
    shares = {d.on: share for d in motors if (share := torque_share(machine, d, speed or 0.0)) is not None}
    if len(motors) == 1 and shares:
        share = a.number("motor_load", shares, "torque of the motor at the operating speed over its rated one")[rotor]
        a.line("motor", f"{100 * share:.3g} % of the rated torque at the fastest stable working point")


def _class_in_words(name: str | None) -> str:
    return "no trip class lets it pass" if name is None else f"trip class {name} lets it pass"
