"""States of parts' own: in a start, in results, as axes of a map."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.refusals import Refusal, refused

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.varied import check_together, start_states, varied_of, with_states
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.studies.basin.spec import Basin
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import run

INVERTER = {"kind": "inverter", "set_speed": 30.0, "gain": 1.0, "integral_time": 0.5, "torque_limit": 5.0}
DAMPER = {"kind": "friction-damper", "name": "left", "angle": 0.0, "force": 20.0}
BUILD_UP = 2e-4
CARRIER = {"directions": "x", "mass": 20.0, "stiffness": 1e4}


def drum(name: str = "drum") -> dict[str, Any]:
    return {"kind": "rotor", "name": name, "mass": 5.0, "eccentricity": 0.0, "inertia": 0.3, "bearing_damping": 0.02}


def machine(**changed: Any) -> Machine:
    given = {"carrier": CARRIER, "bodies": [drum()], "drive": INVERTER, "attachments": [DAMPER]}
    return machine_from({k: v for k, v in (given | changed).items() if v is not None})


def state(of: Machine, start: dict[str, Any]) -> dict[str, float]:
    return dict(zip(of.state_names, initial_state(of, start).tolist(), strict=True))


def test_they_begin_at_zero_or_where_the_start_says() -> None:
    assert {state(machine(), {})[n] for n in ("left.lining", "drive.integral")} == {0.0}
    given = state(machine(), {"left": {"lining": "0.15 mm"}, "drive": {"integral": -2.0}, "drum": 0.3})
    assert (given["left.lining"], given["drive.integral"], given["drum.angle"]) == (pytest.approx(1.5e-4), -2.0, 0.3)


def test_of_several_drives_each_has_its_own() -> None:
    two = machine(bodies=[drum("e1"), drum("e2")], drive=None, drives=[INVERTER | {"on": "e1"}, INVERTER | {"on": "e2"}])
    given = state(two, {"drives": {"e2": {"integral": "3 N m"}}})
    assert (given["drives.e1.integral"], given["drives.e2.integral"]) == (0.0, 3.0)
    with refused("study.start.drives.e3", "e2", given={"integral": 1.0}, code="unknown-key"):
        state(two, {"drives": {"e3": {"integral": 1.0}}})
    with refused("study.start.drives", given=1):
        state(two, {"drives": 1})


@pytest.mark.parametrize(
    ("start", "refusal"),
    [
        ({"left": {"lining": "0.3 mm"}}, refused("study.start.left.lining", "-0.0002", "0.0002 m", given="0.3 mm")),
        ({"left": {"lining": "3 N"}}, refused("study.start.left.lining", "m", code="dimension")),
        ({"left": {"lining": float("nan")}}, refused("study.start.left.lining", given=float("nan"), code="not-finite")),
        ({"left": {"linning": 0}}, refused("study.start.left.linning", "lining", given=0, code="unknown-key")),
        ({"left": 1e-4}, refused("study.start.left", 'lining = "0 m"', given=0.0001)),
        ({"left": {"lining": {"x": 1}}}, refused("study.start.left.lining", "x", given={"x": 1}, code="no-quantity")),
        ({"drive": {"integral": -5.1}}, refused("study.start.drive.integral", "-5", "5 N", "m", given=-5.1)),
        ({"lefd": {"lining": 0}}, refused("study.start.lefd", "left", code="unknown-key")),
        ({"drives": {}}, refused("study.start.drives", code="unknown-key")),
    ],
)
def test_bad_values_are_refused(start: dict[str, Any], refusal: Refusal) -> None:
    with refusal:
        state(machine(), start)


def test_with_free_travel_the_lining_has_that_room_too() -> None:
    wide = machine(attachments=[DAMPER | {"free_travel": "3 mm"}])
    assert state(wide, {"left": {"lining": 3.2e-3}})["left.lining"] == 3.2e-3
    with refused("study.start.left.lining", "-0.0032", "0.0032 m", given=0.0033):
        state(wide, {"left": {"lining": 3.3e-3}})


def test_a_run_up_stores_them_from_their_start_on() -> None:
    """The carrier stands; the controller is at its limit, where T_i x' = T_m - x, and the lining holds what the start drew."""
    result = run(RunUp(until=0.4, start={"left": {"lining": 1e-4}, "drive": {"integral": 1.0}}), machine())
    integral, lining = result["drive.integral"], result["left.lining"]
    assert (integral.dims, integral.units, integral.long_name) == (("time",), "N m", "integral part of the drive")
    assert (lining.units, lining.long_name) == ("m", "lining travel of left")
    limited = result.speed.sel(body="drum").values < 20
    assert integral.values[limited] == pytest.approx(5 - 4 * np.exp(-result.time.values[limited] / 0.5), rel=1e-8)
    assert lining.values[0] == 1e-4
    # The drawn lining pushes with F/2 on the spring's 1e4 N/m: the carrier turns back where both balance.
    assert float(result.displacement.min()) < -BUILD_UP / 4
    assert result.wucht.summary["energy_residual"] < 1e-9


def test_they_are_start_states_of_maps() -> None:
    states = start_states(machine())
    assert (states["left.lining"].unit.si, states["drive.integral"].what) == (
        "m",
        "integral part of the drive at the start",
    )
    two = machine(bodies=[drum("e1"), drum("e2")], drive=None, drives=[INVERTER | {"on": "e1"}, INVERTER | {"on": "e2"}])
    varied = [varied_of(two, name, "axes") for name in ("drives.e1.integral", "drives.e2.integral", "left.lining")]
    given = {"left": {}, "drives": {"e2": {}}}
    made = with_states(given, [(v.state, x) for v, x in zip(varied, (1.0, 2.0, 1e-4), strict=True) if v.state])
    assert made == {"left": {"lining": 1e-4}, "drives": {"e1": {"integral": 1.0}, "e2": {"integral": 2.0}}}
    with refused("study.axes.drives.e2.integral", "study.start", given="drives.e2.integral", code="given-twice"):
        check_together(varied, {"drives": {"e2": {"integral": 1.0}}}, "axes", "an axis")
    check_together(varied, {"drives": {"e3": {"integral": 1.0}}}, "axes", "an axis")


def test_a_map_over_both_of_them() -> None:
    axes = {"drive.integral": ["-4 N m", "4 N m", 2], "left.lining": ["-0.1 mm", "0.1 mm", 2]}
    result = run(Basin(axes=axes, until=2.0), machine(bodies=[drum() | {"eccentricity": 1e-3}]))
    assert sum(result.wucht.summary["fractions"].values()) == pytest.approx(1.0)


def test_a_map_refuses_what_no_lining_has() -> None:
    axes = {"drive.integral": ["-4 N m", "4 N m", 2], "left.lining": ["-0.6 mm", "0.6 mm", 2]}
    with refused("study.axes.left.lining", given=-0.0003):
        run(Basin(axes=axes, until=2.0), machine())
