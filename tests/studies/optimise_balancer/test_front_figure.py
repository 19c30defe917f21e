"""The figure of a front: each point is there, with the mark of its number of bodies."""

from __future__ import annotations

import json

import numpy as np
import pytest
from known_fronts import MACHINE, RANGE, Parabolas

from wucht.dynamics.balancers import candidates
from wucht.studies.optimise_balancer import computation
from wucht.studies.optimise_balancer.spec import OptimiseBalancer
from wucht.studies.runner import draw
from wucht.studies.runner import run as ask


def test_points_of_several_numbers_of_bodies_are_all_drawn_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Five points, with three and with two bodies; of the third number that was tried none is on the front."""
    monkeypatch.setattr(computation, "compensated_state", lambda _machine, full: None)
    monkeypatch.setattr(candidates, "outcomes_of", Parabolas(offset=10.0))
    asked = OptimiseBalancer(
        vary={"damping": RANGE}, objectives=["peak", "settling-time"], samples=2, population=20, evaluations=60, points=5,
        damping_curve=False, model="slow",
    )  # fmt: skip
    result = ask(asked, MACHINE)
    counts = np.array([3, 2, 3, 3, 2])
    assert result.front_bodies.shape == counts.shape
    result.front_bodies.values[:] = counts
    result = result.assign_attrs(summary=json.dumps(result.wucht.summary | {"numbers_of_bodies": [2, 3, 4]}))
    (axis,) = (a for a in draw(result).axes if a.lines)
    columns = {"s": (0, 1.0), "mm": (2, 1e3)}
    (i, over), (j, up) = (columns[label[:-1].split("(")[1]] for label in (axis.get_xlabel(), axis.get_ylabel()))
    drawn = {str(line.get_label()): line for line in axis.lines}
    for what, values in (("by the search", result.front_objective.values), ("checked", result.front_checked.values)):
        for count in (2, 3):
            line, mine = drawn[f"front, {count} bodies: {what}"], values[counts == count]
            assert line.get_xdata() == pytest.approx(over * mine[:, i], rel=1e-12)
            assert line.get_ydata() == pytest.approx(up * mine[:, j], rel=1e-12)
    assert len({drawn[f"front, {count} bodies: checked"].get_marker() for count in (2, 3)}) == 2
    assert not any("4 bodies" in label for label in drawn)
