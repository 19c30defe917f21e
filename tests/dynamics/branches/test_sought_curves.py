"""Where the curves of a map of endings are looked for."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.branches import orbit_endings
from wucht.dynamics.branches.ending_curves import curves_between
from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.orbit_endings import OrbitEnd, OrbitEnding
from wucht.errors import RunError
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT


def place(x: float, y: float, kind: str, **more: Any) -> OrbitEnding:
    return OrbitEnding(x, y, 0.12, OrbitEnd(kind, 0.18, "", **more))


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
    case = EndingMapCase(("p", "x", "y"), ((0.1, 0.2), (10.0, 20.0), (-2.0, 2.0)), motion, 2, None)  # type: ignore[arg-type]
    found = curves_between(case, connected, place(*other, SADDLE_NODE_ON_ORBIT), lambda _: None)
    assert found == ("near x = 12.5, y = 1: enough was asked",)
    assert asked == [
        ("with_values", {"x": 12.5, "y": 1.0}),
        ("orbits", "the equations there", "winding", "scale", "longest"),
        ("states",),
    ]
