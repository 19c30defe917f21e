"""A unit of any factors is read as the SI brochure (9th edition, sections 2.3 and 5.4) has it, or it is refused.

The witness is a table of factors and dimensions of its own: to Pint, which takes angles for plain numbers, ``deg deg`` is an
angle of 3e-4 rad.
"""

from __future__ import annotations

import math
from collections import Counter

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from wucht.schema import Unit

# Factor to SI; powers of kg, m, s, A; whether it has an angle.
NAMES: dict[str, tuple[float, tuple[int, int, int, int], int]] = {
    "kg": (1, (1, 0, 0, 0), 0), "g": (1e-3, (1, 0, 0, 0), 0), "m": (1, (0, 1, 0, 0), 0), "mm": (1e-3, (0, 1, 0, 0), 0),
    "s": (1, (0, 0, 1, 0), 0), "ms": (1e-3, (0, 0, 1, 0), 0), "A": (1, (0, 0, 0, 1), 0), "N": (1, (1, 1, -2, 0), 0),
    "kN": (1e3, (1, 1, -2, 0), 0), "W": (1, (1, 2, -3, 0), 0), "V": (1, (1, 2, -3, -1), 0), "Pa": (1, (1, -1, -2, 0), 0),
    "rad": (1, (0, 0, 0, 0), 1), "deg": (math.pi / 180, (0, 0, 0, 0), 1), "°": (math.pi / 180, (0, 0, 0, 0), 1),
    "turn": (2 * math.pi, (0, 0, 0, 0), 1), "rpm": (math.pi / 30, (0, 0, -1, 0), 1),
}  # fmt: skip
QUANTITIES = {
    "rad": ((0, 0, 0, 0), 1), "rad/s": ((0, 0, -1, 0), 1), "rad/s^2": ((0, 0, -2, 0), 1), "kg": ((1, 0, 0, 0), 0),
    "m": ((0, 1, 0, 0), 0), "m/s^2": ((0, 1, -2, 0), 0), "N": ((1, 1, -2, 0), 0), "N m": ((1, 2, -2, 0), 0),
    "N m s": ((1, 2, -1, 0), 0), "N m/rad": ((1, 2, -2, 0), -1), "N m s/rad": ((1, 2, -1, 0), -1), "N/m": ((1, 0, -2, 0), 0),
    "N s/m": ((1, 0, -1, 0), 0), "kg m^2": ((1, 2, 0, 0), 0), "kg m": ((1, 1, 0, 0), 0), "Wb": ((1, 2, -2, -1), 0),
}  # fmt: skip
Factor = tuple[str, int]
FACTORS = st.lists(st.tuples(st.sampled_from([*NAMES]), st.sampled_from([1, 1, 1, -1, -1, 2, -2])), min_size=1, max_size=4)


def written(factors: list[Factor], sign: str, slash: bool) -> str:
    """The product in one of the ways in which it can be written; it begins with a factor above the stroke."""
    factors = sorted(factors, key=lambda factor: -factor[1]) if slash else factors
    texts = []
    for number, (name, power) in enumerate(factors):
        below = slash and power < 0 and number > 0
        size = -power if below else power
        joint = ("/" if below else sign) if number else ""
        texts.append(joint + name + (f"^{size}" if size != 1 else ""))
    return "".join(texts)


@settings(max_examples=300, deadline=None)
@given(st.sampled_from([*QUANTITIES]), FACTORS, st.sampled_from([" ", "*", " · "]), st.booleans())
@example("rad", [("deg", 1), ("deg", 1)], " ", False)
@example("rad", [("deg", 2)], " ", False)
@example("rad/s", [("rpm", 1), ("deg", 1)], " ", False)
@example("m/s^2", [("m", 1), ("s", -1), ("s", -1)], " ", True)
@example("N m", [("N", 1), ("m", 1), ("rad", 1), ("rad", -1)], "*", True)
@example("rad", [("turn", 1), ("rad", -1)], " ", True)
@example("rad", [("deg", 1), ("°", -1)], " ", False)
@example("kg", [("kg", 1), ("deg", 1)], " ", False)
@example("N m s", [("N", 1), ("m", 1), ("rpm", -1)], " ", True)
def test_a_unit_is_read_as_the_product_that_it_is_or_refused(si: str, factors: list[Factor], sign: str, slash: bool) -> None:
    text = written(factors, sign, slash)
    size = math.prod(NAMES[name][0] ** power for name, power in factors)
    dimension = tuple(sum(NAMES[name][1][k] * power for name, power in factors) for k in range(4))
    plain = [(name.replace("°", "deg"), power) for name, power in factors]  # one unit by two names
    powers = {name: sum(power for other, power in plain if other == name) for name, _ in plain}
    angles = [power for name, power in powers.items() if power and NAMES[name][2]]
    is_once = max(Counter((name, power > 0) for name, power in factors).values()) == 1  # above the stroke, and below it
    of_quantity, angle = QUANTITIES[si]
    try:
        value = Unit(si, "quantity").parse_quantity(f"3 {text}")
    except ValueError:
        # What is certainly right is read.
        assert not (is_once and dimension == of_quantity and angles == ([angle] if angle else []) and factors[0][1] > 0), text
        return
    assert dimension == of_quantity, text
    assert value == pytest.approx(3 * size, rel=1e-12), text
    assert is_once, text
    assert len(angles) <= 1 and all(abs(power) == 1 for power in angles), text
    if angle and angles:
        assert angles == [angle], text
    if angles and not angle:  # a work for each angle; nothing else has an angle that its SI unit has not
        assert of_quantity[:2] == (1, 2), text
