"""The map of how the modulated motion ends: its regions and what is missing, and where its curves are looked for."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from wucht.studies.stability_map.computation import EndingPlan
from wucht.studies.stability_map.map_parts import MapParts

from wucht.dynamics.branches import orbit_endings
from wucht.dynamics.branches.ending_curves import RETURNS, ParameterPlane, curves_between
from wucht.dynamics.branches.ending_map import EndingFindings, EndingMapCase
from wucht.dynamics.branches.orbit_endings import OrbitEnd, OrbitEnding
from wucht.dynamics.branches.plane_regions import PlaneCurve
from wucht.errors import RunError
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT

PLANE = ParameterPlane(("p", "x", "y"), ((0.1, 0.2), (10.0, 20.0), (-2.0, 2.0)))
LINE = PlaneCurve(RETURNS, np.full(41, 15.0), np.linspace(-2.0, 2.0, 41), np.full(41, 0.15))


def place(x: float, y: float, kind: str, **more: Any) -> OrbitEnding:
    return OrbitEnding(x, y, 0.12, OrbitEnd(kind, 0.18, "", **more))


def parts(*curves: PlaneCurve, complete: bool = True) -> MapParts:
    """Of two by two places: those on the left end at a saddle-node, those on the right at a saddle connection."""
    along, second, none = (SimpleNamespace(path=path) for path in ("x", "y", ""))
    case: Any = EndingMapCase(PLANE, none, 2, ())  # type: ignore[arg-type]
    plan = EndingPlan(along, second, PLANE.bounds[1:], (), none, {}, case)  # type: ignore[arg-type]
    kinds = (SADDLE_NODE_ON_ORBIT, SADDLE_CONNECTION)
    places = [place(x, y, kind) for y in (-1.0, 1.0) for x, kind in zip((12.5, 17.5), kinds, strict=True)]
    return plan.parts(EndingFindings(tuple(places), curves, complete=complete))


def test_a_curve_between_places_that_differ_explains_them() -> None:
    made = parts(LINE)
    assert list(made.lines) == ["saddle-node on the orbit | saddle connection"]
    assert {made.labels[made.areas.region_at(12.0, y)] for y in (-1.5, 1.5)} == {"ends at a saddle-node on the orbit"}
    assert {made.labels[made.areas.region_at(18.0, y)] for y in (-1.5, 1.5)} == {"ends at a saddle connection"}
    assert made.omissions == () and made.contradictions == ()


def test_without_one_it_is_said_that_none_was_found() -> None:
    """Of both pairs side by side, once all was looked at."""
    (sentence,) = parts().omissions
    assert sentence.startswith("between 2 pairs of neighbouring places that differ no curve was found, such as x = 12.5, y = ")
    assert "(ends at a saddle-node on the orbit) and 17.5, " in sentence
    assert parts(complete=False).omissions == ()


@pytest.mark.parametrize("other", [(17.5, 1.0), (12.5, -1.0)])
def test_a_curve_is_looked_for_along_the_third_parameter(monkeypatch: pytest.MonkeyPatch, other: tuple[float, float]) -> None:
    """At the place whose orbit ends at a connection, in orbits and steady states."""
    asked: list[tuple[Any, ...]] = []

    class Asked:
        subject = "the equations there"

        def with_values(self, values: dict[str, float]) -> Asked:
            asked.append(("with_values", values))
            return self

        @property
        def equilibria(self) -> None:
            asked.append(("states",))
            raise RunError("enough was asked")

    def through(subject: Any, seed: Any) -> tuple[None, None]:
        asked.append(("orbits", subject, seed.winding, seed.scale, seed.longest))
        return None, None

    monkeypatch.setattr(orbit_endings, "cycles_through", through)
    seed: Any = SimpleNamespace(winding="winding", scale="scale", longest="longest")
    connected = place(12.5, 1.0, SADDLE_CONNECTION, last=seed, equilibrium=np.zeros(2))
    motion: Any = Asked()
    found = curves_between(motion, PLANE, connected, place(*other, SADDLE_NODE_ON_ORBIT), lambda _: None)
    assert found.omissions == ("near x = 12.5, y = 1: enough was asked",)
    assert asked == [
        ("with_values", {"x": 12.5, "y": 1.0}),
        ("orbits", "the equations there", "winding", "scale", "longest"),
        ("states",),
    ]
