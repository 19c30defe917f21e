"""A carrier of one's own that does not bear every body: its refusal is located at the body, with the code that it has there."""

from __future__ import annotations

import pytest
from tests.refusals import refused

from wucht import Machine
from wucht.errors import FieldError
from wucht.extending import SI, Body, si
from wucht.machines.parts.carrier import Carrier
from wucht.machines.parts.rotor import Rotor

DRUM = Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia="0.03 kg m^2")


class WeakCarrier(Carrier):
    """It bears each body up to a mass."""

    strength: SI[float] = si("kg", "largest mass of a body", gt=0)

    def check_body(self, body: Body) -> None:
        """Nor does it bear bodies beside its middle."""
        super().check_body(body)
        if body.mass > self.strength:  # type: ignore[attr-defined]
            raise FieldError("mass", f"must be at most {self.strength:g} kg on this carrier", code="limits")


def on_carrier(strength: str, body: Body = DRUM) -> Machine:
    return Machine(WeakCarrier(stiffness="1e5 N/m", damping="200 N s/m", strength=strength), [body])


def test_a_body_that_it_bears() -> None:
    assert on_carrier("9 kg").values["drum.mass"] == 9.0


@pytest.mark.parametrize("strength", ["8.9 kg", "500 g"])
def test_a_body_that_it_refuses(strength: str) -> None:
    with refused("drum.mass", "on this carrier", given=9.0, code="limits"):
        on_carrier(strength)


def test_a_refusal_of_the_package_has_no_code_of_its_own() -> None:
    with refused("drum.position", "xyr", given=[0.1, 0.0]):
        on_carrier("9 kg", Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia="0.03 kg m^2", position=(0.1, 0.0)))
