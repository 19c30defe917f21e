"""Findings -> the Dataset of a stability map, with the answer in numbers and in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.conventions import answered, variable
from wucht.studies.stability_map.map_parts import F, MapParts, MapPlan, shares

if TYPE_CHECKING:
    import xarray as xr

_MOST_LOST = 4


def dataset(plan: MapPlan[F], findings: F) -> xr.Dataset:
    """The Dataset of a stability map.

    Boundaries, one after another (boundary_point): boundary_x, boundary_y, boundary_value (of the eliminated parameter, not a
    number without one), boundary; boundary_name, boundary_group (boundary_number). Points where boundaries meet (mark): mark_x,
    mark_y, mark_value, mark_kind, mark_label. Places that were looked at (place): place_x, place_y, place_label, place_begins,
    place_ends. The plane (y, x), whose coordinates are the values of both parameters: region, an index; of each (region_number)
    region_label, region_tone (0 without, 1 with a modulated motion that is unstable, 2 with a stable one; of endings their
    kind), region_hatch, region_x, region_y: its inmost place.
    """
    import xarray as xr_

    parts = plan.parts(findings)
    a, b, third = plan.along, plan.second, plan.third
    unit = third.unit if third is not None else ""
    what = third.words if third is not None else "third parameter"
    numbers = np.repeat(np.arange(len(parts.lines)), [len(line.x) for line in parts.lines]).astype(int)
    x, y, value = (np.concatenate([np.empty(0), *(getattr(line, n) for line in parts.lines)]) for n in ("x", "y", "value"))
    inmost = np.array([parts.areas.inmost(k) for k in range(parts.areas.count)]).T
    data = {
        "boundary_x": variable("boundary_point", x, a.words, a.unit),
        "boundary_y": variable("boundary_point", y, b.words, b.unit),
        "boundary_value": variable("boundary_point", value, what, unit),
        "boundary": variable("boundary_point", numbers, "boundary"),
        "boundary_name": variable("boundary_number", np.array([line.name for line in parts.lines], "U96"), "name"),
        "boundary_group": variable("boundary_number", np.array([line.group for line in parts.lines], "U96"), "drawn alike"),
        "mark_x": variable("mark", [m.x for m in parts.marks], a.words, a.unit),
        "mark_y": variable("mark", [m.y for m in parts.marks], b.words, b.unit),
        "mark_value": variable("mark", [m.value for m in parts.marks], what, unit),
        "mark_kind": variable("mark", np.array([m.kind for m in parts.marks], "U32"), "kind of the point"),
        "mark_label": variable("mark", np.array([m.label for m in parts.marks], "U48"), "point in words"),
        "place_x": variable("place", [p.x for p in parts.places], a.words, a.unit),
        "place_y": variable("place", [p.y for p in parts.places], b.words, b.unit),
        "place_label": variable("place", np.array([p.label for p in parts.places], "U96"), "what is the case there"),
        "place_begins": variable("place", [p.begins for p in parts.places], f"{what} where the motion begins", unit),
        "place_ends": variable("place", [p.ends for p in parts.places], f"{what} where the motion ends", unit),
        "region": variable("y x", parts.areas.index.astype(np.int16), "region"),
        "region_label": variable("region_number", np.array(parts.labels, "U96"), "what is the case there"),
        "region_tone": variable("region_number", np.array(parts.tones, int), "tone"),
        "region_hatch": variable("region_number", np.array(parts.hatches, int), "hatch"),
        "region_x": variable("region_number", inmost[0], a.words, a.unit),
        "region_y": variable("region_number", inmost[1], b.words, b.unit),
    }  # fmt: skip
    coordinates = {
        "x": variable("x", parts.areas.x, a.words, a.unit),
        "y": variable("y", parts.areas.y, b.words, b.unit),
    }
    summary = _summary(plan, parts)
    return answered(
        xr_.Dataset(data, coords=coordinates), summary, summary["sentence"], _warnings(plan, findings, parts),
        along=a.path, along_unit=a.unit, along_what=a.words, second=b.path, second_unit=b.unit, second_what=b.words,
        eliminated="" if third is None else third.path, everywhere=", ".join(parts.everywhere),
        low=plan.bounds[0][0], high=plan.bounds[0][1], second_low=plan.bounds[1][0], second_high=plan.bounds[1][1],
    )  # fmt: skip


def _summary(plan: MapPlan[Any], parts: MapParts) -> dict[str, Any]:
    third = plan.third
    return {
        "sentence": _sentence(plan, parts),
        "along": plan.along.path, "along_unit": plan.along.unit, "range": list(plan.bounds[0]),
        "second": plan.second.path, "second_unit": plan.second.unit, "second_range": list(plan.bounds[1]), **plan.keys,
        "boundaries": {line.name: np.array([line.x, line.y]).T.tolist() for line in parts.lines},
        "boundary_values": {line.name: line.value.tolist() for line in parts.lines if np.isfinite(line.value).all()},
        "points": [
            {"kind": m.kind, plan.along.path: m.x, plan.second.path: m.y}
            | ({} if third is None or math.isnan(m.value) else {third.path: m.value})
            for m in parts.marks
        ],
        "regions": [{"label": label, "share": share} for label, share in shares(parts.areas, parts.labels).items()],
        "everywhere": list(parts.everywhere),
        "places": len(parts.places), "against": len(parts.against), "runs": parts.runs,
    }  # fmt: skip


def _sentence(plan: MapPlan[Any], parts: MapParts) -> str:
    if not parts.places:
        return "the study was interrupted before a place was looked at"
    areas = sorted(shares(parts.areas, parts.labels).items(), key=lambda area: -area[1])
    return plan.sentence(parts, dict(areas))


def _warnings(plan: MapPlan[F], findings: F, parts: MapParts) -> list[str]:
    lines = [*plan.warnings, *parts.lost[:_MOST_LOST]]
    if len(parts.lost) > _MOST_LOST:
        lines.append(f"so are {len(parts.lost) - _MOST_LOST} more")
    if parts.against and findings.complete:
        p = parts.against[0]
        where = f"{plan.along.path} = {p.x:.4g}, {plan.second.path} = {p.y:.4g}"
        lines.append(
            f"{len(parts.against)} of {len(parts.places)} places say otherwise than their region, such as {where}: {p.label}"
        )
    if not findings.complete:
        lines.append(f"{len(parts.places)} places were looked at; the map is not finished")
    return lines
