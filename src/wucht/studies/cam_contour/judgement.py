"""Whether a cam can be cut, and does what is permitted, in a label and a sentence."""

from __future__ import annotations

from collections.abc import Iterator

from wucht.cams.shape import CALLED, degrees, largest_pressure_angle
from wucht.numerics.angles import Arc
from wucht.studies.cam_contour.computation import Findings, Plan

_REACHED = 1e-6  # of a limit: beyond it by less is at it, where a smallest cam is
_MOST_ARCS = 3


def judged(plan: Plan, findings: Findings) -> tuple[str, str]:
    """The label (``cuttable``, ``undercut``, ``not-permitted``, ``lifts-off``) and the sentence."""
    if not plan.whole:
        return "undercut", f"undercut: {'; '.join(_cut(plan))}"
    broken, off = list(_broken(plan, findings)), list(_off(plan, findings))
    if broken:
        return "not-permitted", "; ".join([f"cuttable, but not as permitted: {', '.join(broken)}", *off])
    said = [f"cuttable: {_radius(plan)}"]
    if any(s.pressure_angle.value > 0 for s in plan.shapes.values()):
        angle = largest_pressure_angle(plan.shapes.values())
        said[0] += f", pressure angle at most {degrees(angle.value)} at {degrees(angle.phi)}"
    return ("lifts-off" if off else "cuttable"), "; ".join([*said, *off])


def _radius(plan: Plan) -> str:
    convex = [s.convex for s in plan.shapes.values() if s.convex is not None]
    if not convex:
        return "the contour is nowhere convex"
    least = min(convex, key=lambda radius: radius.radius)
    return f"least convex radius {_millimetres(least.radius)} at {degrees(least.phi)}"


def _cut(plan: Plan) -> Iterator[str]:
    for name, shape in plan.shapes.items():
        if shape.missing or shape.undercut:
            yield f"the {shape.part} cuts the {CALLED[name]} away {_arcs(shape.missing or shape.undercut)}"


def _broken(plan: Plan, findings: Findings) -> Iterator[str]:
    permitted = plan.spec.permitted
    if permitted is None:
        return
    angle = largest_pressure_angle(plan.shapes.values())
    if permitted.pressure_angle is not None and angle.value > permitted.pressure_angle * (1 + _REACHED):
        reached = f"pressure angle {degrees(angle.value)} at {degrees(angle.phi)}"
        yield f"{reached} (permitted {degrees(permitted.pressure_angle)})"
    convex = [s.convex.radius for s in plan.shapes.values() if s.convex is not None]
    if permitted.least_radius is not None and convex and min(convex) < permitted.least_radius * (1 - _REACHED):
        yield f"least radius {_millimetres(min(convex))} (permitted {_millimetres(permitted.least_radius)})"
    base = min(shape.base.value for shape in plan.shapes.values())
    if permitted.shaft_radius is not None and base < permitted.shaft_radius * (1 - _REACHED):
        yield f"base circle {_millimetres(base)} (permitted {_millimetres(permitted.shaft_radius)}, that of the shaft)"
    if permitted.contact_pressure is not None and findings.largest is not None:
        largest = max(float(pressure.max()) for pressure in findings.largest.pressure.values())
        if largest > permitted.contact_pressure:
            yield f"contact pressure {largest / 1e6:.4g} MPa (permitted {permitted.contact_pressure / 1e6:.4g} MPa)"


def _off(plan: Plan, findings: Findings) -> Iterator[str]:
    """Where a roller leaves its cam; in a groove it goes over to the other flank."""
    if findings.largest is None or "outer" in plan.cams:
        return
    for name, arcs in findings.largest.off.items():
        if arcs:
            of = "" if len(plan.cams) == 1 else f" of the {CALLED[name]}"
            unit = "N m" if plan.unit == "rad" else "N"
            part = plan.shapes[name].part
            yield f"the {part}{of} lifts off {_arcs(arcs)} (a preload of {findings.largest.least_preload:.4g} {unit} holds it)"


def _arcs(arcs: tuple[Arc, ...]) -> str:
    shown = " and ".join(f"from {degrees(begin)} to {degrees(end)}" for begin, end in arcs[:_MOST_ARCS])
    return shown + (f" and on {len(arcs) - _MOST_ARCS} more arcs" if len(arcs) > _MOST_ARCS else "")


def _millimetres(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
