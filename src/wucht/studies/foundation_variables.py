"""Forces into the foundation in an answer."""

from __future__ import annotations

import math
from collections.abc import Mapping

from wucht.analysis.foundation_forces import SupportDirection
from wucht.dynamics.run_ups.foundation_loads import FoundationLoads, StaticLoads
from wucht.machines.machine import Machine
from wucht.studies.answer import Answer
from wucht.studies.bearing_variables import force_text

_MOST = 12  # supports with a line each
TRANSMISSIBILITY = "share of the exciting force that passes into the foundation", ""
ISOLATION = "{transmissibility:%} of the exciting force passes into the foundation"


def state_static_loads(a: Answer, machine: Machine) -> StaticLoads | None:
    """State the forces on the foundation at rest, and how far the supports give way, and return them."""
    static = StaticLoads.of(machine)
    if static is not None:
        of_rest = "force of each support on the foundation at rest, along x and y"
        a.number("static_foundation_forces", forces_by_support(static.forces), of_rest, "N")
        a.number("static_deflection", dict(static.deflections), "deflection of each support under the weight", "length")
    return static


def state_foundation_loads(a: Answer, static: StaticLoads | None, loads: FoundationLoads | None, mark: str = "") -> None:
    """State the forces on the foundation in a run, with a line on the largest. static: the loads at rest, stated already."""
    if loads is None:
        return
    in_operation = "amplitude of the force of each support on the foundation at the end, along x and y"
    at_most = "largest force of each support on the foundation in the whole run, beyond that at rest, along x and y"
    a.number("foundation_forces", _forces_of_supports(static, loads), "force of each support on the foundation", "N")
    a.number("foundation_force_amplitudes", forces_by_support(loads.amplitudes), in_operation, "N")
    a.number("peak_foundation_forces", forces_by_support(loads.peaks), at_most, "N")
    a.number("transmissibility", loads.transmissibility, f"{TRANSMISSIBILITY[0]} at the end")
    key = max(loads.peaks, key=lambda key: loads.peaks[key])
    text = f"\u00b1{force_text(loads.amplitudes[key])} in operation, \u00b1{force_text(loads.peaks[key])} at most in the run"
    a.line("foundation", "{forces}", forces=f"{_place(key, loads.peaks)}: {_at_rest_in_words(key, static)}{text}{mark}")


def _forces_of_supports(static: StaticLoads | None, loads: FoundationLoads) -> dict[str, dict[str, float | None]]:
    """Return the force at rest, the amplitude in operation and the largest force of each support, along x or y."""
    of_each = [forces_by_support(f) for f in (loads.amplitudes, loads.peaks)]
    rest = {} if static is None else forces_by_support(static.forces)
    return {
        support: {
            "static": math.hypot(*rest[support].values()) if support in rest else None,
            "dynamic": max(of_each[0][support].values()),
            "largest": max(of_each[1][support].values()),
        }
        for support in of_each[0]
    }


def state_largest_forces(a: Answer, way: str, static: StaticLoads | None, peaks: Mapping[SupportDirection, float]) -> None:
    """State the largest forces on the foundation on a way, ``up`` or ``down``, or empty of a run of one way."""
    if not peaks:
        return
    on_way, key = (f" on the way {way}", f"peak_foundation_forces_{way}") if way else ("", "peak_foundation_forces")
    what = f"largest force of each support on the foundation{on_way}, beyond that at rest, along x and y"
    a.number(key, forces_by_support(peaks), what, "N")
    largest = max(peaks, key=lambda k: peaks[k])
    at_rest = _at_rest_in_words(largest, static)
    text = f"{_place(largest, peaks)}: {at_rest}\u00b1{force_text(peaks[largest])} at most{on_way}"
    a.line("foundation", "{forces}", forces=text)


def forces_in_words(amplitudes: Mapping[SupportDirection, float]) -> str:
    """Return the largest of the amplitudes in operation as text."""
    key = max(amplitudes, key=lambda k: amplitudes[k])
    return f"{_place(key, amplitudes)}: \u00b1{force_text(amplitudes[key])}"


def _place(key: SupportDirection, forces: Mapping[SupportDirection, float]) -> str:
    return f"{key.support} in {key.direction}" if len(forces_by_support(forces)) > 1 else f"in {key.direction}"


def _at_rest_in_words(key: SupportDirection, static: StaticLoads | None) -> str:
    return "" if static is None or not static.forces[key] else f"{force_text(abs(static.forces[key]))} at rest, "


def tell_isolation(a: Answer, static: StaticLoads | None, loads: FoundationLoads | None) -> None:
    """Add lines on what passes into the foundation, on the deflection, and on each of several supports."""
    if loads is None:
        return
    a.line("isolation", ISOLATION)
    if static is not None:
        a.line("deflection", "{static_deflection} under the weight")
    supports = {n: forces for n, forces in forces_by_support(loads.peaks).items() if any(forces.values())}
    for name in list(supports)[:_MOST] if len(supports) > 1 else ():
        a.line(
            name,
            "{forces}",
            forces="; ".join(_force_in_words(SupportDirection(name, d), static, loads) for d in supports[name]),
        )


def _force_in_words(key: SupportDirection, static: StaticLoads | None, loads: FoundationLoads) -> str:
    swing, most = force_text(loads.amplitudes[key]), force_text(loads.peaks[key])
    return f"{key.direction} {_at_rest_in_words(key, static)}\u00b1{swing}, \u00b1{most} at most"


def forces_by_support(forces: Mapping[SupportDirection, float]) -> dict[str, dict[str, float]]:
    """Return forces by support, and by direction."""
    supports: dict[str, dict[str, float]] = {}
    for (support, direction), force in forces.items():
        supports.setdefault(support, {})[direction] = force
    return supports
