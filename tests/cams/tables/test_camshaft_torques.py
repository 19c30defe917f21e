"""The torques on a camshaft and its speed, by hand; and where its drive is too weak."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.prediction import CamShaft, _positive, unresolved_share
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.camshaft import CamshaftDrive, ElasticTable, ShaftTable
from wucht.errors import InputError
from wucht.numerics.fourier_series import FourierSeries

HERE = Path()
MOTOR = {"kind": "linear", "slope": 2.0, "no_load_speed": 100.0}


def drive(torque: float = 0.0, friction: float = 0.0, slope: float = 1.0) -> CamshaftDrive:
    """A torque that falls with the speed, from the load on."""

    def torques(speeds: np.ndarray) -> Any:
        speeds = np.asarray(speeds, float)
        load = np.where(speeds > 0, friction, 0.0)
        return np.array([torque - slope * speeds, load]), np.array([np.full_like(speeds, -slope), np.full_like(speeds, 0.25)])

    return CamshaftDrive(torques, 50.0, False, friction, 0.5)


def test_the_torque_of_a_drive_less_its_loads() -> None:
    torque, slope = drive(20.0, 3.0).net(np.array([0.0, 4.0]))
    assert (torque.tolist(), slope.tolist()) == ([20.0, 13.0], [-1.25, -1.25])


@pytest.mark.parametrize(
    ("torque", "friction", "speed", "stands"),
    [
        (2.0, 3.0, 1.9, True),
        (2.0, 3.0, 2.0, False),  # four times the transition of 0.5 rad/s
        (3.0, 3.0, 0.0, True),
        (3.1, 3.0, 0.0, False),
        (-1.0, 0.0, 0.0, False),
    ],
)
def test_dry_friction_holds_a_shaft(torque: float, friction: float, speed: float, stands: bool) -> None:
    assert bool(drive(torque, friction).stall_reason(speed)) is stands


def test_a_drive_that_does_not_start_its_load_may_carry_it_later() -> None:
    """A torque that rises with the speed exceeds the friction of 3 N m from 20 rad/s on, of ten times the speed at most."""
    later = drive(2.0, 3.0, slope=-0.05)
    assert later.no_speed_reason(2.1) == "" and later.no_speed_reason(1.9) != ""
    assert drive(4.0, 3.0).no_speed_reason(0.01) == "" and drive(2.0, 3.0).no_speed_reason(100.0) != ""


def test_the_speed_of_a_shaft_with_a_load() -> None:
    """2 (100 - w) = 0.5 w at 80 rad/s; an expected speed takes its place."""
    loads = ({"kind": "viscous", "coefficient": 0.5},)
    common: dict[str, Any] = {"inertia": 3.0, "output_inertia": 0.2, "drive": MOTOR, "loads": loads}
    driving = ShaftTable(**common).camshaft_drive(HERE)
    assert driving is not None and not driving.is_enforced
    assert (driving.speed, driving.inertia, driving.friction) == (pytest.approx(80.0), 0.0, 0.0)
    torque, slope = driving.net(np.array([0.0, 80.0]))
    assert torque == pytest.approx([200.0, 0.0], abs=1e-9) and slope == pytest.approx([-2.5, -2.5])
    expected = ShaftTable(**common, mean_speed=70.0).camshaft_drive(HERE)
    assert expected is not None and expected.speed == 70.0
    shaft = ShaftTable(**common).camshaft(driving, "rad")
    assert (shaft.inertia, shaft.output_inertia, shaft.mean_speed) == (3.0, 0.2, pytest.approx(80.0))
    assert shaft.torque is not None and shaft.torque(np.array([0.0]))[0] == pytest.approx([200.0])


def test_a_drive_that_enforces_its_speed_has_no_torque() -> None:
    table = ShaftTable(inertia=3.0, output_mass=0.2, drive={"kind": "constant-speed", "speed": 40.0})
    driving = table.camshaft_drive(HERE)
    assert driving is not None and driving.is_enforced and driving.speed == 40.0
    shaft = table.camshaft(driving, "m")
    assert shaft.torque is None and shaft.mean_speed == 40.0
    with refused("shaft.output_mass"):
        table.camshaft(driving, "rad")
    with refused("shaft.mean_speed", given=30.0):
        ShaftTable(inertia=3.0, output_mass=0.2, mean_speed=30.0, drive=table.drive).camshaft_drive(HERE)


@pytest.mark.parametrize(
    ("changes", "location", "code"),
    [
        ({"loads": ({"kind": "viscous", "coefficient": 0.5},)}, "shaft.loads", None),
        ({}, "shaft.mean_speed", None),
        ({"drive": MOTOR | {"no_load_speed": -100.0}}, "shaft.drive", "turns-back"),
        ({"drive": MOTOR | {"no_load_speed": 0.0}}, "shaft.drive", "turns-back"),
        ({"drive": {"kind": "constant-torque", "torque": 1.0}}, "shaft.drive", "no-limit"),
    ],
)
def test_shafts_without_a_speed(changes: dict[str, Any], location: str, code: str | None) -> None:
    with refused(location, **({} if code is None else {"code": code}), **({"given": changes["drive"]["kind"]} if code else {})):
        ShaftTable(inertia=3.0, output_inertia=0.2, **changes).camshaft_drive(HERE)


def test_a_weak_drive_does_not_start_its_shaft() -> None:
    """150 N m of dry friction against 100 N m; an expected speed makes no difference where no speed is possible."""
    loads = ({"kind": "coulomb", "torque": 150.0, "transition_speed": 0.01},)
    weak: dict[str, Any] = {"inertia": 3.0, "output_inertia": 0.2, "drive": MOTOR | {"slope": 1.0}, "loads": loads}
    for more in ({}, {"mean_speed": 60.0}):
        with refused("shaft.drive", given="linear", code="stands"):
            ShaftTable(**weak, **more).camshaft_drive(HERE)
    strong = ShaftTable(**weak | {"drive": MOTOR}).camshaft_drive(HERE)
    assert strong is not None and strong.speed == pytest.approx(25.0, rel=1e-6)
    assert (strong.friction, strong.transition) == (150.0, 0.01)


def test_springs_of_a_camshaft() -> None:
    elastic = ElasticTable(shaft_stiffness=500.0, shaft_damping=2.0, cam_inertia=0.3)
    shaft = ShaftTable(inertia=3.0, output_inertia=0.2, elastic=elastic).twisting()
    assert shaft is not None
    assert (shaft.inertia, shaft.stiffness, shaft.damping) == (0.3, 500.0, 2.0)
    assert ShaftTable(inertia=3.0, output_inertia=0.2).twisting() is None
    assert ShaftTable(inertia=3.0, output_inertia=0.2, elastic=ElasticTable(output_frequency=50.0)).twisting() is None
    output = ElasticTable(output_frequency=50.0).output(0.2, "m")
    assert output is not None
    assert (output.stiffness, output.damping) == pytest.approx((500.0, 2 * 0.02 * 10.0))
    assert elastic.output(0.2, "m") is None
    with refused("shaft.elastic"):
        ElasticTable(output_frequency=50.0).output(0.0, "m")
    with refused("shaft.inertia", given=0.3):
        ShaftTable(inertia=0.3, output_inertia=0.2, elastic=elastic)


def test_energy_and_eigenmotion_of_a_shaft() -> None:
    """J = J0 + J1 psi'(0)^2; without a torque all else stays."""
    law = FourierSeries.of(0.0, [], [0.5])
    shaft = CamShaft(2.0, 0.8, 30.0, lambda w: (w, w))
    motion = ShaftMotion(FourierSeries.of(30.0, [1.0]))
    assert shaft.energy(law, motion) == pytest.approx((2.0 + 0.8 * 0.25) * 31.0**2 / 2)
    free = shaft.without_torque(25.0)
    assert (free.inertia, free.output_inertia, free.mean_speed, free.torque) == (2.0, 0.8, 25.0, None)
    tau = np.array([0.3])
    power = CamShaft(2.0, 0.8, 3.0).power_at_constant_speed(law, 4)
    at = np.array([0.0, math.pi / 2, math.pi, 3 * math.pi / 2]) + 0 * tau
    assert power == pytest.approx(0.8 * 27.0 * 0.5 * np.cos(at) * -0.5 * np.sin(at), abs=1e-12)


def test_the_share_of_a_speed_that_is_not_resolved() -> None:
    """None with fewer points than the most; there the largest of the highest quarter of the orders."""
    few = FourierSeries.of(10.0, np.zeros(100), np.r_[np.zeros(99), 0.5])
    assert unresolved_share(ShaftMotion(few)) == 0.0
    many = FourierSeries.of(10.0, np.zeros(1023), np.r_[np.zeros(1022), 0.5])
    assert unresolved_share(ShaftMotion(many)) == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("given", "location"),
    [
        ({"output_frequency": 5.0, "output_stiffness": 5.0}, "output_stiffness"),
        ({"output_frequency": 5.0, "output_damping_ratio": 0.1, "output_damping": 5.0}, "output_damping"),
        ({"shaft_stiffness": 5.0}, "cam_inertia"),
        ({"cam_inertia": 5.0}, "shaft_stiffness"),
        ({"output_damping_ratio": 0.1}, "output_frequency"),
    ],
)
def test_springs_that_contradict_each_other(given: dict[str, float], location: str) -> None:
    with pytest.raises(InputError) as error:
        ElasticTable(**given)
    assert error.value.location == f"shaft.elastic.{location}"


def test_a_speed_that_falls_below_zero_is_the_expected_one_there() -> None:
    values = _positive(FourierSeries.of(0.5, [1.0]), 4, 7.0)
    assert values == pytest.approx([1.5, 0.5, 7.0, 0.5])
