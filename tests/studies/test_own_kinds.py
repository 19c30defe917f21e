"""Kinds of bodies, carriers and drives written elsewhere run in every study: none decides by the classes of the package."""

import subprocess
import sys
from collections.abc import Iterator
from typing import Any, ClassVar, Literal

import numpy as np
import pytest
import sympy as sp
from tests.refusals import refused

from wucht import InputError, Machine, Response, RunUp, TorqueBalance, run
from wucht.errors import FieldError
from wucht.files.building import machine_from
from wucht.machines.models import DimensionlessMachine, models
from wucht.machines.parts import bodies, carriers
from wucht.machines.parts.base import Body, Drive, Frame, Point, si
from wucht.machines.parts.support import Support
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate


class Disc(Body):
    """A thin disc with a hole: an unbalanced rotor that knows its radius, and no eccentricity, mass or inertia by that name."""

    kind: ClassVar[str] = ""

    weight: float = si("kg", "mass", "m", gt=0)
    radius: float = si("m", "radius", "r", gt=0)
    hole: float = si("kg m", "unbalance of the hole", "U", gt=0)

    def moment(self) -> sp.Expr:
        """That of the hole."""
        return self.symbol("hole")

    def energies(self, frame: Frame) -> Energies:
        """Carried mass with unbalance, m r^2 phi'^2/4."""
        m, r = self.symbols("weight", "radius")
        turning = Energies(kinetic=m * r**2 * frame.speed(self.name) ** 2 / 4)
        return frame.carried_energies(m, self.moment(), self.name) + turning


class Beam(Support):
    """A mass in the middle of a beam, which bends up and down."""

    kind: ClassVar[str] = ""

    directions: Literal["own-beam"] = "own-beam"
    bending: float = si("N m^2", "bending stiffness", "EI", gt=0)
    span: float = si("m", "length", "L", gt=0)
    loss: float = si("N s/m", "damping", "b", 0.0, ge=0)
    mass: float = si("kg", "mass", "m", gt=0)

    @property
    def labels(self) -> tuple[str, ...]:
        """y."""
        return ("y",)

    def coordinates(self) -> tuple[Coordinate, ...]:
        """The deflection."""
        return (Coordinate.from_names("carrier.y", "carrier.vy", prescribed_velocity=self.prescribed_velocity("y")),)

    def check_body(self, body: Body) -> None:
        """None that is heavier than a tonne."""
        super().check_body(body)
        if getattr(body, "weight", 0.0) > 1e3:
            raise FieldError("weight", "must be at most a tonne", code="too-heavy")

    def reference_frame(self) -> Frame:
        """In the middle."""
        (y,) = self.coordinates()
        return Frame(centre=Point(y=y.position, vy=y.velocity), gravity=self.symbol("gravity"))

    def energies(self, frame: Frame) -> Energies:
        """The stiffness in the middle of a beam on two supports is 48 EI/L^3."""
        m, bending, span, b = self.symbols("mass", "bending", "span", "loss")
        at = frame.centre
        return Energies(m * at.vy**2 / 2, 24 * bending / span**3 * at.y**2 + m * frame.gravity * at.y, b * at.vy**2 / 2)


class Slipping(Drive):
    """torque = 2 pull_out/(s/s_k + s_k/s), with the slip s = 1 - speed/synchronous: Kloss' formula."""

    kind: ClassVar[str] = ""

    pull_out: float = si("N m", "breakdown torque", "M_k", gt=0)
    slip: float = si("", "breakdown slip", "s_k", gt=0)
    synchronous: float = si("rad/s", "synchronous speed", "w_s", gt=0)

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """Multiplied out by the slip."""
        most, sk, ws = self.symbols("pull_out", "slip", "synchronous")
        s = 1 - speed / ws
        return 2 * most * s * sk / (s**2 + sk**2)

    def synchronous_speed(self) -> float:
        """As given."""
        return self.synchronous

    def breakdown(self) -> tuple[float, float, float]:
        """As given."""
        return self.slip, self.synchronous * (1 - self.slip), self.pull_out


class OneOfOurOwn(DimensionlessMachine):
    """A dimensionless rotor without a motor."""

    kind: ClassVar[str] = ""
    equations: ClassVar[str] = "ours"
    directions: ClassVar[str] = "x"

    sigma: float = si("", "damping", "sigma", ge=0)

    def energies(self, frame: Frame) -> Energies:
        """T = xi'^2/2 + phi'^2/2."""
        return Energies(kinetic=frame.centre.vx**2 / 2 + frame.speed("rotor") ** 2 / 2)


def test_a_kind_of_a_part_that_is_taken_is_refused() -> None:
    Disc.kind = "rotor"
    try:
        with pytest.raises(InputError) as refusal:
            bodies()
    finally:
        Disc.kind = "own-disc"
    assert (refusal.value.value, "Disc" in str(refusal.value)) == ("rotor", True)


@pytest.fixture(scope="module", autouse=True)
def _known_here_alone() -> Iterator[None]:
    """The kinds have names while these tests run: other tests list those of the package."""
    names = {Disc: "own-disc", Beam: "own-beam", Slipping: "own-kloss", OneOfOurOwn: "own-model"}
    for cls, name in names.items():
        cls.kind = name
    yield
    for cls in names:
        cls.kind = ""


DISC = {"kind": "own-disc", "name": "disc", "weight": 10.0, "radius": 0.1, "hole": 0.01}
ROTOR = {"kind": "rotor", "name": "disc", "mass": 10.0, "eccentricity": 1e-3, "inertia": 0.05}
BEAM = {"directions": "own-beam", "mass": 2.0, "bending": 1e5 / 48, "span": 1.0, "loss": 200.0}
SPRINGS = {"directions": "y", "mass": 2.0, "stiffness": 1e5, "damping": 200.0}
KLOSS = {"kind": "own-kloss", "pull_out": 3.0, "slip": 0.1, "synchronous": 157.0}
MOTOR = {"kind": "linear", "slope": 0.02, "no_load_speed": 157.0}


def of(body: dict[str, Any], carrier: dict[str, Any], drive: dict[str, Any]) -> Machine:
    return machine_from({"bodies": [body], "carrier": carrier, "drive": drive})


@pytest.mark.parametrize("drive", [KLOSS, MOTOR])
@pytest.mark.parametrize("carrier", [BEAM, SPRINGS])
def test_own_kinds_do_what_those_of_the_package_do(carrier: dict[str, Any], drive: dict[str, Any]) -> None:
    own, known = of(DISC, carrier, drive), of(ROTOR, SPRINGS, drive)
    for question in (Response(), TorqueBalance()):
        actual, expected = (run(question, m) for m in (own, known))
        for name in ("amplitude", "vibration_torque"):
            if name in expected:
                assert actual[name].values == pytest.approx(expected[name].values, rel=1e-9)
    ran, expected = (run(RunUp(until=1.0), m) for m in (own, known))
    assert not ran.attrs.get("failure")
    assert ran.speed.values[0, -1] == pytest.approx(expected.speed.values[0, -1], rel=1e-6)
    assert ran.amplitude.values[-1] == pytest.approx(expected.amplitude.values[-1], rel=1e-5)


def test_a_rotor_that_tells_no_eccentricity_has_no_centre_distance() -> None:
    actual = run(Response(), of(DISC, SPRINGS, MOTOR))
    assert np.isnan(actual.centre_distance.values).all()
    assert actual.amplitude.values.max() > 0


def test_own_carriers_and_models_are_found() -> None:
    assert carriers()["own-beam"] is Beam
    assert {"x", "y", "xy", "fixed", "xyr", "r"} <= set(carriers())
    assert models()["own-model"] is OneOfOurOwn
    machine = machine_from({"model": "own-model", "parameters": {"sigma": 0.1}})
    assert machine.values == {"sigma": 0.1}


def test_an_own_carrier_takes_bodies_in_its_middle_alone() -> None:
    with refused("machine.bodies[0] (disc).position", "xyr", "own-beam", given=[0.1, 0.0]):
        of({**ROTOR, "position": [0.1, 0.0]}, BEAM, MOTOR)


TOYS = """
from typing import ClassVar
from wucht.extending import Drive, Load

def toy(base, **methods):
    names = {"kind": "own-toy", "__annotations__": {"kind": ClassVar[str]}, "__module__": __name__}
    try:
        return type("Toy", (base,), names | methods).kind
    except TypeError as error:
        return str(error)

class Middle(Drive):
    "Without a kind: not yet a part."

print(toy(Drive), toy(Load), sep="\\n")
print(toy(Middle, torque=lambda self, speed: speed), toy(Middle, prescribed_speed=lambda self: 1))
print(toy(Load, torque=Drive.torque))
"""


def test_a_part_of_a_shaft_without_a_torque_is_refused() -> None:
    """It would be zero without a word. In a process of its own: kinds are known from then on."""
    lines = subprocess.run([sys.executable, "-c", TOYS], check=True, capture_output=True, text=True).stdout.splitlines()
    assert lines[:2] == [
        f"Toy, a {group} of the kind 'own-toy', must have a method torque(self, speed)" for group in ("drive", "load")
    ]
    assert lines[2] == "own-toy own-toy" and lines[3] == lines[1], "the torque of the base class is none"


def test_a_body_that_its_carrier_refuses_has_the_code_of_the_refusal() -> None:
    with refused("machine.bodies[0] (disc).weight", given=2e3, code="too-heavy"):
        machine_from({"carrier": BEAM, "bodies": [DISC | {"weight": 2e3}], "drive": MOTOR})
