"""Equations that preserve volume have no attractors."""

from __future__ import annotations

import pytest

from wucht.dynamics.limit_sets.conservation import preserves_volume
from wucht.files.user_system import equations_from

HENON_HEILES = {"x": "u", "y": "v", "u": "-x - 2*x*y", "v": "-y - x^2 + y^2"}


@pytest.mark.parametrize(
    ("states", "parameters", "conserves"),
    [
        (HENON_HEILES, {}, True),
        ({"x": "v", "v": "-sin(x) - d*v"}, {"d": 0.0}, True),
        ({"x": "v", "v": "-sin(x) - d*v"}, {"d": 0.1}, False),
        ({"x": "v", "v": "-x + x*v^2", "z": "z*(1 - 2*x*v)"}, {}, False),  # only where x v is zero
        ({"x": "sin(y)", "y": "sin(z)", "z": "sin(x)"}, {}, True),  # no energy is needed
        ({"x": "10*(y - x)", "y": "x*(28 - z) - y", "z": "x*y - 8/3*z"}, {}, False),
    ],
)
def test_volume_is_preserved_where_the_divergence_is_zero(
    states: dict[str, str], parameters: dict[str, float], conserves: bool
) -> None:
    assert preserves_volume(equations_from({"states": states, "parameters": parameters})) is conserves
