"""The answer of a stability map: its boundaries, the points where they meet, the places examined, and the regions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.labelled_maps import LabelledMap, detection_limit
from wucht.dynamics.branches.plane_regions import DOUBLE, NOT_DECIDED
from wucht.dynamics.branches.state_map import StateMapCase
from wucht.dynamics.branches.steady_states import MODULATED_MOTION
from wucht.schema import Parameter
from wucht.studies.answer import Answer

_MOST_LOST = 4
_LARGE_LIMIT, _CELLS = 0.1, 12  # share of the plane; cells a side that leave less
_NAMES, _RANGES = ("along", "second", "eliminate"), ("range", "second_range", "eliminate_range")


def state_map(
    a: Answer, parameters: Sequence[Parameter], case: StateMapCase | EndingMapCase, labelled_map: Callable[[], LabelledMap]
) -> None:  # fmt: skip
    """State the map. parameters: of the plane, and that which is eliminated, if there is one."""
    (along, second, *_), parts = parameters, labelled_map()
    ranges = (*case.bounds, *([] if isinstance(case, StateMapCase) else [case.ranges[0]]))
    a.attribute(
        along=along.path, along_unit=along.unit, along_what=along.full_name, second=second.path, second_unit=second.unit,
        second_what=second.full_name, eliminated=parameters[2].path if len(parameters) > 2 else "",
        everywhere=", ".join(parts.everywhere), low=ranges[0][0], high=ranges[0][1], second_low=ranges[1][0],
        second_high=ranges[1][1],
    )  # fmt: skip
    for name, range_name, parameter, ends in zip(_NAMES, _RANGES, parameters, ranges, strict=False):
        a.number(name, parameter.path, "parameter")
        a.number(f"{name}_unit", parameter.unit, "its unit")
        a.number(range_name, list(ends), f"range of the {parameter.full_name}", parameter.unit)
    a.curve("x", parts.areas.x, along.full_name, along.unit)
    a.curve("y", parts.areas.y, second.full_name, second.unit)
    _state_boundaries(a, parameters, parts)
    _state_points(a, parameters, parts)
    _state_places(a, parameters, parts)
    _state_regions(a, along, second, parts)
    agreeing = len(parts.places) - len(parts.contradictions)
    runs = f", by {parts.runs} runs from several starts," if parts.runs else ""
    a.line("checked", f"{agreeing} of {len(parts.places)} separately examined places{runs} agree with the boundaries")
    a.sentence = _sentence(parameters, case, parts)
    _warn(a, along, second, case, parts)


def _third(parameters: Sequence[Parameter]) -> tuple[str, str]:
    """Return name and unit of the parameter that is eliminated."""
    return (parameters[2].full_name, parameters[2].unit) if len(parameters) > 2 else ("third parameter", "")


def _state_boundaries(a: Answer, parameters: Sequence[Parameter], parts: LabelledMap) -> None:
    (along, second, *_), lines = parameters, parts.lines
    numbers = np.repeat(np.arange(len(lines)), [len(line.x) for line in lines.values()]).astype(int)
    x, y, value = (np.concatenate([np.empty(0), *(getattr(line, n) for line in lines.values())]) for n in ("x", "y", "value"))
    a.curve("boundary_x", x, along.full_name, along.unit, "boundary_point")
    a.curve("boundary_y", y, second.full_name, second.unit, "boundary_point")
    a.curve("boundary_value", value, *_third(parameters), "boundary_point")
    a.curve("boundary", numbers, "boundary", "", "boundary_point")
    a.curve("boundary_name", np.array([*lines], "U96"), "name", "", "boundary_number")
    groups = np.array([line.kind for line in lines.values()], "U96")
    a.curve("boundary_group", groups, "group of one style", "", "boundary_number")
    places = {name: np.array([line.x, line.y]).T.tolist() for name, line in lines.items()}
    values = {name: line.value.tolist() for name, line in lines.items() if np.isfinite(line.value).all()}
    a.number("boundaries", places, "points of the boundaries")
    a.number("boundary_values", values, "values of the eliminated parameter there")
    for name, line in lines.items():
        (left, right), (low, high) = ((v.min(), v.max()) for v in (line.x, line.y))
        a.line(f"{name}: {along.path} from {left:.5g} to {right:.5g}, {second.path} from {low:.5g} to {high:.5g}", "")


def _state_points(a: Answer, parameters: Sequence[Parameter], parts: LabelledMap) -> None:
    """State the points at which boundaries meet."""
    (along, second, *_), marks = parameters, parts.marks
    labels = [mark.kind.replace("-", " ") for mark in marks]
    values = [[x for x in (m.x, m.y, m.value)[: len(parameters)] if not math.isnan(x)] for m in marks]
    a.curve("mark_x", [m.x for m in marks], along.full_name, along.unit, "mark")
    a.curve("mark_y", [m.y for m in marks], second.full_name, second.unit, "mark")
    a.curve("mark_value", [m.value for m in marks], *_third(parameters), "mark")
    a.curve("mark_kind", np.array([m.kind for m in marks], "U32"), "kind of the point", "", "mark")
    drawn_labels = ["connection of two saddle-nodes" if m.kind == DOUBLE else x for m, x in zip(marks, labels, strict=True)]
    a.curve("mark_label", np.array(drawn_labels, "U48"), "label of the point", "", "mark")
    of_parameters = {
        p.path: ([row[k] if k < len(row) else None for row in values], p.full_name, p.unit) for k, p in enumerate(parameters)
    }
    a.table_of("points", "points at which boundaries meet", optional=tuple(of_parameters), columns=of_parameters | {
        "kind": ([m.kind for m in marks], "kind of the point"), "values": (values, "values of the parameters"),
    })  # fmt: skip
    for label, row in zip(labels, values, strict=True):
        at = ", ".join(f"{p.path} = {value:.7g}" for p, value in zip(parameters, row, strict=False))
        a.line(f"{label}: {at}", "")


def _state_places(a: Answer, parameters: Sequence[Parameter], parts: LabelledMap) -> None:
    (along, second, *_), places, (third, unit) = parameters, parts.places, _third(parameters)
    a.curve("place_x", [p.x for p in places], along.full_name, along.unit, "place")
    a.curve("place_y", [p.y for p in places], second.full_name, second.unit, "place")
    a.curve("place_label", np.array([p.label for p in places], "U96"), "motions there", "", "place")
    a.curve("place_begins", [p.begins for p in places], f"{third} where the motion begins", unit, "place")
    a.curve("place_ends", [p.ends for p in places], f"{third} where the motion ends", unit, "place")
    a.number("places", len(places), "number of separately computed places")
    against = "number of places that no boundary separates from different ones"
    a.number("against", len(parts.contradictions), against)
    a.number("runs", parts.runs, "number of runs")
    limit = "share of the plane below which a motion may be missed, in 19 of 20 cases"
    a.number("detection_limit", parts.detection_limit, limit)


def _state_regions(a: Answer, along: Parameter, second: Parameter, parts: LabelledMap) -> None:
    inmost, shares = np.array([parts.areas.innermost_point(k) for k in range(parts.areas.count)]).T, parts.shares
    a.curve("region", parts.areas.index.astype(np.int16), "region", "", "y x")
    a.curve("region_label", np.array(parts.labels, "U96"), "motions there", "", "region_number")
    a.curve("region_tone", np.array(parts.tones, int), "tone", "", "region_number")
    a.curve("region_hatch", np.array(parts.hatches, int), "hatch", "", "region_number")
    a.curve("region_x", inmost[0], along.full_name, along.unit, "region_number")
    a.curve("region_y", inmost[1], second.full_name, second.unit, "region_number")
    a.table(
        "regions", "regions of the plane",
        label=(list(shares), "motions there"),
        share=([of_plane for of_plane, _ in shares.values()], "share of the plane"),
        uncertainty=(
            [off for _, off in shares.values()],
            "uncertainty of the share, in 19 of 20 cases: by the resolution; of absence, what may be missed",
        ),
    )  # fmt: skip
    a.number("everywhere", list(parts.everywhere), "stable states in the whole plane")
    for label, (of_plane, off) in shares.items():
        a.line(f"{100 * of_plane:6.2f} ± {100 * off:.2f} %  {label}", "")


def _sentence(parameters: Sequence[Parameter], case: StateMapCase | EndingMapCase, parts: LabelledMap) -> str:
    if not parts.places:
        return "the study was interrupted before the first place"
    areas = sorted(((label, of_plane) for label, (of_plane, _) in parts.shares.items()), key=lambda area: -area[1])
    listing = [f"{label} in {100 * of_plane:.0f} %" for label, of_plane in areas]
    if isinstance(case, EndingMapCase):
        along, second, third = parameters
        at = [f"{along.value_text(m.x, 7)}, {second.value_text(m.y, 7)}" for m in parts.marks]
        meeting = f"; the regions meet at {' and at '.join(at)}" if at else ""
        return f"the {case.labels.orbit}, as {third.sentence_name} changes: {', '.join(listing)} of the plane{meeting}"
    everywhere = f"stable everywhere: {', '.join(parts.everywhere)}; in addition " if parts.everywhere else "stable: "
    limit = f"; what exists in less than {100 * parts.detection_limit:.2g} % of it may be missed at the places examined"
    names = " and ".join(case.only or ())
    only = f"; of the steady states {names} alone were sought" if names else ""
    left_out = f"; {case.labels.orbit}s were not searched for" if case.motion is None else ""
    return f"{everywhere}{'; '.join(listing)} of the plane{limit}{only}{left_out}"


def _warn(a: Answer, along: Parameter, second: Parameter, case: StateMapCase | EndingMapCase, parts: LabelledMap) -> None:
    omissions = [sentence.replace(MODULATED_MOTION, case.labels.orbit) for sentence in parts.omissions[:_MOST_LOST]]
    a.warn(*case.labels.warnings, *omissions)
    if len(parts.omissions) > _MOST_LOST:
        a.warn(f"and {len(parts.omissions) - _MOST_LOST} more")
    if parts.contradictions and parts.complete:
        place = parts.contradictions[0]
        a.warn(
            f"no boundary separates {len(parts.contradictions)} of {len(parts.places)} places from others that differ, such as "
            f"{along.path} = {place.x:.4g}, {second.path} = {place.y:.4g}: {place.label}; "
            f"what lies between them is {NOT_DECIDED}"
        )
    if parts.complete and parts.searches and parts.detection_limit > _LARGE_LIMIT:
        less = f"study.cells = {_CELLS} leaves {100 * detection_limit(_CELLS**2):.0f} %"
        a.warn(
            f"the plane was searched at {parts.searches} places only: another motion may exist in up to "
            f"{100 * parts.detection_limit:.0f} % of it; {less}"
        )
    if not parts.complete:
        a.warn(f"{len(parts.places)} places are examined; the map is not finished")
