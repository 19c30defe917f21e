"""Springs and dampers of a carrier by natural frequency and damping ratio: c = M omega_0^2, b = 2 D sqrt(c M)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from wucht.errors import FieldError

Pair = float | tuple[float, float]  # of x and y, or one that holds for both
Inertia = Callable[[str], float]  # the mass or moment of inertia that moves with a coordinate of the carrier, by its label
_UNITS = {
    "stiffness": "N/m", "damping": "N s/m", "rotation_stiffness": "N m", "rotation_damping": "N m s",
}  # fmt: skip
UNTUNED = dict.fromkeys(("rotation_frequency", "rotation_damping_ratio"))  # once their spring and damper are known


def tuned_stiffness(inertia: float, frequency: Pair) -> Pair:
    """c, of a natural frequency in rad/s."""
    return each(lambda w: inertia * w**2, frequency)


def tuned_damping(inertia: float, stiffness: Pair, ratio: Pair) -> Pair:
    """b, of a damping ratio."""
    return each(lambda c, d: 2 * d * math.sqrt(c * inertia), stiffness, ratio)


def tuned_rotation(carrier: Any, inertia: Inertia) -> dict[str, Pair]:
    """Spring and damper of the rotation of a carrier that turns, by their keys: those that its frequency and ratio say."""
    found: dict[str, Pair] = {}
    if carrier.rotation_frequency is not None:
        found["rotation_stiffness"] = tuned_stiffness(inertia("r"), carrier.rotation_frequency)
    if carrier.rotation_damping_ratio is not None:
        stiffness = found.get("rotation_stiffness", carrier.rotation_stiffness or 0.0)
        found["rotation_damping"] = tuned_damping(inertia("r"), stiffness, carrier.rotation_damping_ratio)
    return found


def refuse_both(carrier: Any, one: str, other: str) -> None:
    """Raises ``ValueError(field, sentence)`` where what one key says is given by another too."""
    if getattr(carrier, other) is not None and one in carrier.model_fields_set and getattr(carrier, one) is not None:
        raise FieldError(other, f"give either {one} or {other}", code="either-or")


def refuse_rotation_both_ways(carrier: Any) -> None:
    """Raises ``ValueError(field, sentence)`` where the rotation's spring or damper is given in two ways, or has no spring."""
    refuse_both(carrier, "rotation_stiffness", "rotation_frequency")
    refuse_both(carrier, "rotation_damping", "rotation_damping_ratio")
    spring = carrier.rotation_stiffness if carrier.rotation_frequency is None else carrier.rotation_frequency
    refuse_ratio_without_spring("rotation_damping_ratio", carrier.rotation_damping_ratio, spring)


def refuse_ratio_without_spring(key: str, ratio: Pair | None, spring: Pair | None) -> None:
    """Raises ``ValueError(field, sentence)`` for a damping ratio in a direction without a spring. spring: or a frequency."""
    missing = each(lambda d, c: float(d > 0 and c == 0), ratio or 0.0, spring or 0.0)
    if missing == 1.0 or (isinstance(missing, tuple) and any(missing)):
        raise FieldError(
            key, "must go with a stiffness or frequency above 0: without a spring no damping is critical", code="no-stiffness"
        )


def each(function: Callable[..., float], *values: Pair) -> Pair:
    """A function of values of both directions: one number where all are."""
    if not any(isinstance(v, tuple) for v in values):
        return function(*values)
    pairs = [v if isinstance(v, tuple) else (v, v) for v in values]
    return function(*(x for x, _ in pairs)), function(*(y for _, y in pairs))


def in_words(found: Mapping[str, Pair | None], inertia: str) -> str:
    """What follows from frequency and damping ratio, by its key. inertia: with which, in words."""
    shown = (f"{key} {_shown(value)} {_UNITS[key]}" for key, value in found.items())
    return f"{', '.join(shown)}, by frequency or damping ratio with {inertia}"


def _shown(value: Pair | None) -> str:
    return " and ".join(f"{v:.6g}" for v in (value if isinstance(value, tuple) else (value or 0.0,)))
