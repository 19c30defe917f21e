"""The drawing of a machine: to scale where lengths are known, for every machine of the catalogue."""

from __future__ import annotations

import json
import math
from itertools import combinations
from types import SimpleNamespace
from typing import Any

import pytest
from matplotlib.patches import Circle

from wucht.files.catalogue import load_document, load_machine, names
from wucht.machine_shape import MachineShape
from wucht.plots.inline_svg import inline_svg
from wucht.plots.machine_drawing import draw_machine, shape_in_result
from wucht.studies.subjects import MACHINE


def _result(name: str, **values: Any) -> Any:
    """What a drawing reads of a result."""
    description = MACHINE.describe(load_machine(name, values))
    facts, parts = json.loads(json.dumps([description.facts, description.parts]))
    return SimpleNamespace(wucht=SimpleNamespace(machine=facts, parts=parts, dimensionless=description.dimensionless))


def _shape(name: str, **values: Any) -> MachineShape:
    shape = shape_in_result(_result(name, **values).wucht)
    assert shape is not None
    return shape


def test_a_ring_of_balls_is_to_scale() -> None:
    shape = _shape("practice/grinder-4-balls")
    (wheel,) = shape.rotors
    assert shape.to_scale
    assert [(b.name, b.kind, b.track, b.size) for b in wheel.bodies] == [(f"b{k}", "roller", 0.029, 0.004) for k in range(1, 5)]
    assert [b.arm for b in wheel.bodies] == pytest.approx([0.025] * 4)
    assert wheel.radius > 0.029
    figure = draw_machine(_result("practice/grinder-4-balls"))
    circles = [p for p in figure.axes[0].patches if isinstance(p, Circle)]
    balls = [c.center for c in circles if c.radius == 0.004]
    assert [math.hypot(*at) for at in balls] == pytest.approx([0.025] * 4)
    assert min(math.dist(a, b) for a, b in combinations(balls, 2)) == pytest.approx(0.025 * math.sqrt(2))


def test_mounts_and_rotors_are_at_their_places() -> None:
    shape = _shape("practice/screen")
    assert [(m.x, m.y, m.dy, m.has_damper) for m in shape.mounts] == [
        (-0.9, -0.2, -1.0, True), (0.9, -0.2, -1.0, True),
    ]  # fmt: skip
    assert [(r.name, r.x, r.y, r.sense) for r in shape.rotors] == [("e1", 0.5, 0.2, 1), ("e2", 0.2, 0.5, -1)]
    e1, e2 = shape.rotors
    assert math.dist((e1.x, e1.y), (e2.x, e2.y)) > e1.radius + e2.radius
    left, bottom, right, top = shape.box
    assert left < -0.9 < 0.9 < right
    assert bottom <= -0.2 < 0.5 + e2.radius < top


def test_springs_are_those_of_the_directions() -> None:
    both = _shape("practice/grinder-2-balls")
    assert [(m.dx, m.dy) for m in both.mounts] == [(-1.0, 0.0), (0.0, -1.0)]
    assert [m.has_damper for m in _shape("practice/grinder-2-balls", **{"carrier.damping": 0.0}).mounts] == [False, False]
    one = _shape("sperling-vibration/entrainment-band")
    assert [(m.dx, m.dy) for m in one.mounts] == [(-1.0, 0.0)]


@pytest.mark.parametrize("every", [7, pytest.param(1, marks=pytest.mark.slow)])
def test_every_machine_is_drawn_with_the_names_of_its_bodies_apart(every: int) -> None:
    for name in names()[::every]:
        if "machine" not in load_document(name)[0]:
            continue
        result = _result(name)
        figure = draw_machine(result)
        words = [t for t in figure.axes[0].texts if t.get_text()]
        assert {body for body, _, _ in result.wucht.machine["bodies"]} <= {t.get_text() for t in words}, name
        renderer = figure.canvas.get_renderer()
        boxes = [(t.get_text(), t.get_window_extent(renderer)) for t in words]
        page = figure.bbox.padded(1.0)
        beyond = [t for t, box in boxes if not (page.contains(box.x0, box.y0) and page.contains(box.x1, box.y1))]
        assert beyond == [], name
        upon = [(a, b) for (a, x), (b, y) in combinations(boxes, 2) if x.padded(-2.0).overlaps(y.padded(-2.0))]
        assert upon == [], name


def test_an_inline_drawing_is_small_unique_and_without_addresses() -> None:
    figure = draw_machine(_result("practice/screen"))
    first, again, other = (inline_svg(figure, prefix, "a &amp; b") for prefix in ("a", "a", "b"))
    assert first == again
    assert first.replace("a-", "b-").count(' id="b-') == other.count(' id="b-') > 0
    assert first.startswith('<svg role="img" aria-label="a &amp; b"')
    assert "http" not in first
    assert "<style" not in first
    assert ">e1</text>" in first
    assert len(first) < 40_000
