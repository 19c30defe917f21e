"""The load of motors in an answer."""

from __future__ import annotations

from collections.abc import Mapping

from wucht.dynamics.run_ups.motor_loads import MotorLoad, torque_share
from wucht.machines.machine import Machine
from wucht.studies.answer import Answer

_MOST = 4  # motors named one by one


def state_motor_loads(a: Answer, loads: Mapping[str, MotorLoad], mark: str = "") -> None:
    """State the load of motors whose rated data are known, by the body that they drive, with lines on it."""
    if not loads:
        return

    def of_motors(name: str) -> dict[str, float | str | None]:
        return {on: getattr(load, name) for on, load in loads.items()}

    a.number("motor_torque_share", of_motors("torque_share"), "mean torque of each motor at the end over its rated one")
    a.number("motor_power_share", of_motors("power_share"), "mean power of each motor at the end over its rated one")
    over_start = "root mean square of the torque of each motor over the start"
    a.number("starting_rms_torque", of_motors("starting_torque"), over_start, "N m")
    a.number("starting_rms_share", of_motors("starting_share"), f"{over_start}, over its rated one")
    shown_motors = sorted(loads, key=lambda on: -loads[on].torque_share)[:_MOST]
    listing = ", ".join(f"{on} {100 * loads[on].torque_share:.3g} %" for on in loads if on in shown_motors)
    starting = ", ".join(f"{on} {100 * loads[on].starting_share:.3g} %" for on in loads if on in shown_motors)
    a.line("motors", "{loads}", loads=f"{listing} of the rated torque in operation; {starting} (rms) over the start{mark}")
    heats = {on: load.heat for on, load in loads.items() if load.heat is not None}
    if heats:
        a.number("starting_heat", heats, "I^2 t of each motor over the start, in units of its rated current squared", "s")
        classes = {on: loads[on].trip_class for on in heats}
        what = "fastest trip class of an overload relay that lets the start of each motor pass, IEC 60947-4-1"
        a.number("trip_class", classes, what)
        texts = [f"{on} {heats[on]:.3g} s, {_class_in_words(classes[on])}" for on in heats if on in shown_motors]
        a.line("start", "{heats}", heats=f"I\u00b2t over that of the rated current: {'; '.join(texts)}")


def state_motor_shares(a: Answer, machine: Machine, rotor: str, speed: float | None) -> None:
    """State the load of the motors of a rotor at its operating speed, if there is one and their rated data are known."""
    motors = [] if speed is None else [d for d in machine.drives if d.on == rotor]
    shares = {d.on: share for d in motors if (share := torque_share(machine, d, speed or 0.0)) is not None}
    if len(motors) == 1 and shares:
        share = a.number("motor_torque_share", shares, "torque of the motor at the operating speed over its rated one")[rotor]
        a.line("motor", f"{100 * share:.3g} % of the rated torque at the fastest stable working point")


def _class_in_words(name: str | None) -> str:
    return "no trip class lets it pass" if name is None else f"trip class {name} lets it pass"
