"""Findings -> the quantities of a stability map, and its lines in a report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.branches.plane_regions import DOUBLE, NOT_DECIDED, PlanePoint
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.schema import Parameter
from wucht.studies.stability_map.map_parts import MODULATED_MOTION, F, MapParts, MapPlan, detection_limit, plane_shares

if TYPE_CHECKING:
    import xarray as xr


_MOST_LOST = 4
_LARGE_LIMIT, _CELLS = 0.1, 12  # share of the plane; cells a side that leave less


def dataset(plan: MapPlan[F], findings: F) -> xr.Dataset:
    """Return the Dataset of a stability map."""
    parts = plan.parts(findings)
    a, b, third = plan.along, plan.second, plan.third
    unit = third.unit if third is not None else ""
    third_label = third.full_name if third is not None else "third parameter"
    lines = parts.lines.values()
    numbers = np.repeat(np.arange(len(lines)), [len(line.x) for line in lines]).astype(int)
    x, y, value = (np.concatenate([np.empty(0), *(getattr(line, n) for line in lines)]) for n in ("x", "y", "value"))
    inmost = np.array([parts.areas.innermost_point(k) for k in range(parts.areas.count)]).T
    quantities = [
        Quantity("x", parts.areas.x, a.full_name, a.unit, "x"),
        Quantity("y", parts.areas.y, b.full_name, b.unit, "y"),
        Quantity("boundary_x", x, a.full_name, a.unit, "boundary_point"),
        Quantity("boundary_y", y, b.full_name, b.unit, "boundary_point"),
        Quantity("boundary_value", value, third_label, unit, "boundary_point"),
        Quantity("boundary", numbers, "boundary", "", "boundary_point"),
        Quantity("boundary_name", np.array([*parts.lines], "U96"), "name", "", "boundary_number"),
        Quantity("boundary_group", np.array([line.kind for line in lines], "U96"), "group of one style", "", "boundary_number"),
        Quantity("mark_x", [m.x for m in parts.marks], a.full_name, a.unit, "mark"),
        Quantity("mark_y", [m.y for m in parts.marks], b.full_name, b.unit, "mark"),
        Quantity("mark_value", [m.value for m in parts.marks], third_label, unit, "mark"),
        Quantity("mark_kind", np.array([m.kind for m in parts.marks], "U32"), "kind of the point", "", "mark"),
        Quantity("mark_label", np.array([_mark_label(m) for m in parts.marks], "U48"), "label of the point", "", "mark"),
        Quantity("place_x", [p.x for p in parts.places], a.full_name, a.unit, "place"),
        Quantity("place_y", [p.y for p in parts.places], b.full_name, b.unit, "place"),
        Quantity("place_label", np.array([p.label for p in parts.places], "U96"), "motions there", "", "place"),
        Quantity("place_begins", [p.begins for p in parts.places], f"{third_label} where the motion begins", unit, "place"),
        Quantity("place_ends", [p.ends for p in parts.places], f"{third_label} where the motion ends", unit, "place"),
        Quantity("region", parts.areas.index.astype(np.int16), "region", "", "y x"),
        Quantity("region_label", np.array(parts.labels, "U96"), "motions there", "", "region_number"),
        Quantity("region_tone", np.array(parts.tones, int), "tone", "", "region_number"),
        Quantity("region_hatch", np.array(parts.hatches, int), "hatch", "", "region_number"),
        Quantity("region_x", inmost[0], a.full_name, a.unit, "region_number"),
        Quantity("region_y", inmost[1], b.full_name, b.unit, "region_number"),
        *_summary(plan, parts),
    ]  # fmt: skip
    return result_dataset(
        quantities, _sentence(plan, parts), _warnings(plan, findings, parts),
        along=a.path, along_unit=a.unit, along_what=a.full_name, second=b.path, second_unit=b.unit, second_what=b.full_name,
        eliminated="" if third is None else third.path, everywhere=", ".join(parts.everywhere),
        low=plan.bounds[0][0], high=plan.bounds[0][1], second_low=plan.bounds[1][0], second_high=plan.bounds[1][1],
    )  # fmt: skip


def _summary(plan: MapPlan[Any], parts: MapParts) -> list[Quantity]:
    parameters = [p for p in (plan.along, plan.second, plan.third) if p is not None]
    points = [_point_entry(m, parameters) for m in parts.marks]
    shares = plane_shares(parts.areas, parts.labels)
    regions = [
        {"label": label, "share": share, "uncertainty": parts.uncertainty(label, off)} for label, (share, off) in shares.items()
    ]
    lines = {name: np.array([line.x, line.y]).T.tolist() for name, line in parts.lines.items()}
    values = {name: line.value.tolist() for name, line in parts.lines.items() if np.isfinite(line.value).all()}
    point_columns = {p.path: (p.full_name, p.unit) for p in parameters}
    point_columns |= {"kind": ("kind of the point", ""), "values": ("values of the parameters", "")}
    region_columns = {
        "label": ("motions there", ""), "share": ("share of the plane", ""),
        "uncertainty": ("uncertainty of the share, in 19 of 20 cases: by the resolution; of absence, what may be missed", ""),
    }  # fmt: skip
    names, ranges = ("along", "second", "eliminate"), ("range", "second_range", "eliminate_range")
    axes = zip(names, ranges, parameters, (*plan.bounds, plan.ends), strict=False)
    return [
        *(
            q
            for name, range_, p, ends in axes
            for q in (
                Quantity(name, p.path, "parameter"),
                Quantity(f"{name}_unit", p.unit, "its unit"),
                Quantity(range_, list(ends), f"range of the {p.full_name}", p.unit),
            )
        ),
        Quantity("boundaries", lines, "points of the boundaries"),
        Quantity("boundary_values", values, "values of the eliminated parameter there"),
        *table("points", points, "points at which boundaries meet", point_columns),
        *table("regions", regions, "regions of the plane", region_columns),
        Quantity("everywhere", list(parts.everywhere), "stable states in the whole plane"),
        Quantity("places", len(parts.places), "number of separately computed places"),
        Quantity("against", len(parts.contradictions), "number of places that no boundary separates from different ones"),
        Quantity("runs", parts.runs, "number of runs"),
        Quantity(
            "detection_limit", parts.detection_limit, "share of the plane below which a motion may be missed, in 19 of 20 cases"
        ),
    ]


def _mark_label(mark: PlanePoint) -> str:
    return "connection of two saddle-nodes" if mark.kind == DOUBLE else mark.kind.replace("-", " ")


def _point_entry(mark: PlanePoint, parameters: Sequence[Parameter]) -> dict[str, Any]:
    """Return the entry of a point, with its values under the names of the parameters too, unless they are other keys."""
    values = [x for x in (mark.x, mark.y, mark.value)[: len(parameters)] if not math.isnan(x)]
    return dict(zip([p.path for p in parameters], values, strict=False)) | {"kind": mark.kind, "values": values}


def _sentence(plan: MapPlan[Any], parts: MapParts) -> str:
    if not parts.places:
        return "the study was interrupted before the first place"
    shares = {label: share for label, (share, _) in plane_shares(parts.areas, parts.labels).items()}
    return plan.sentence(parts, dict(sorted(shares.items(), key=lambda area: -area[1])))


def _warnings(plan: MapPlan[F], findings: F, parts: MapParts) -> list[str]:
    lines = [*plan.warnings, *(line.replace(MODULATED_MOTION, plan.motion) for line in parts.omissions[:_MOST_LOST])]
    if len(parts.omissions) > _MOST_LOST:
        lines.append(f"and {len(parts.omissions) - _MOST_LOST} more")
    if parts.contradictions and findings.complete:
        p = parts.contradictions[0]
        location = f"{plan.along.path} = {p.x:.4g}, {plan.second.path} = {p.y:.4g}"
        lines.append(
            f"no boundary separates {len(parts.contradictions)} of {len(parts.places)} places from others that differ, such as "
            f"{location}: {p.label}; what lies between them is {NOT_DECIDED}"
        )
    if findings.complete and parts.searches and parts.detection_limit > _LARGE_LIMIT:
        less = f"study.cells = {_CELLS} leaves {100 * detection_limit(_CELLS**2):.0f} %"
        lines.append(
            f"the plane was searched at {parts.searches} places only: another motion may exist in up to "
            f"{100 * parts.detection_limit:.0f} % of it; {less}"
        )
    if not findings.complete:
        lines.append(f"{len(parts.places)} places are examined; the map is not finished")
    return lines


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a stability map."""
    s = result.wucht.summary
    along, second = s["along"], s["second"]
    lines = [result.attrs["title"], f"verdict: {s['sentence']}"]
    for name, line in s["boundaries"].items():
        xs, ys = zip(*line, strict=True)
        lines.append(f"  {name}: {along} from {min(xs):.5g} to {max(xs):.5g}, {second} from {min(ys):.5g} to {max(ys):.5g}")
    for p in s["points"]:
        at = zip((along, second, s.get("eliminate")), p["values"], strict=False)
        lines.append(f"  {p['kind'].replace('-', ' ')}: {', '.join(f'{name} = {value:.7g}' for name, value in at)}")
    for region in s["regions"]:
        lines.append(f"  {100 * region['share']:6.2f} ± {100 * region['uncertainty']:.2f} %  {region['label']}")
    agree = s["places"] - s["against"]
    runs = f", by {s['runs']} runs from several starts," if s.get("runs") else ""
    lines.append(f"  checked      {agree} of {s['places']} separately examined places{runs} agree with the boundaries")
    return lines
