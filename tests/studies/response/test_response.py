"""The study ``response``: keys, defaults, refusals; undamped, balanced and turning carriers; the command."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import Refusal, refused

from wucht import Machine, Response, draw, load_machine, report, run
from wucht.files.building import machine_from

ROTOR = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.05}
LINEAR = {"kind": "linear", "slope": 0.05, "no_load_speed": 250.0}


def machine(bodies: Any = (ROTOR,), drive: Any = LINEAR, **carrier: Any) -> Machine:
    given = {"mass": 3.0, "stiffness": 2e4, "damping": 40.0} | carrier
    described = {"carrier": {k: v for k, v in given.items() if v is not None}, "bodies": list(bodies)}
    return machine_from(described | ({"drive": drive} if drive else {}))


K = math.sqrt(2e4 / 5)


# --- keys ---


def test_defaults() -> None:
    result = run(Response(), machine())
    assert result.speed.values[[0, -1]] == pytest.approx([0.02 * K, 1.5 * 250])
    assert result.sizes["speed"] > 600
    assert (np.diff(result.speed.values) > 0).all()


@pytest.mark.parametrize(
    ("natural", "drive", "expected"),
    [
        ((50.0, 200.0), 100.0, (4.0, 600.0)),
        ((50.0, 200.0), -500.0, (4.0, 750.0)),  # clockwise
        ((5.0, 200.0), None, (1.5, 600.0)),
        ((0.0, 0.0), 100.0, (2.0, 300.0)),
        ((0.0, 0.0), None, (0.02, 3.0)),
    ],
)
def test_the_default_range_holds_all_resonances_and_the_speed_of_the_drive(
    natural: tuple[float, float], drive: float | None, expected: tuple[float, float]
) -> None:
    m = machine(drive=drive and LINEAR | {"no_load_speed": drive}, stiffness=[5 * w**2 for w in natural])
    assert run(Response(points=2), m).wucht.summary["range"] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("carrier", "refusal"),
    [
        ({"directions": "fixed", "stiffness": None, "damping": 0.0}, refused("machine.carrier", code="fixed")),
        (
            {"directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": 6.0}},
            refused("machine.carrier", code="prescribed"),
        ),
    ],
)
def test_nothing_to_vibrate(carrier: dict[str, Any], refusal: Refusal) -> None:
    with refusal:
        run(Response(), machine(**carrier))


@pytest.mark.slow
def test_a_carrier_moved_in_one_direction_vibrates_in_the_other() -> None:
    result = run(Response(), machine(motion={"direction": "x", "amplitude": 1e-3, "frequency": 6.0}))
    alone = run(Response(), machine(directions="y"))
    assert list(result.direction.values) == ["y"]
    assert result.amplitude.values == pytest.approx(alone.amplitude.values, rel=1e-12)
    assert "prescribed motion" in result.attrs["warnings"]


# --- results ---


@pytest.mark.slow
def test_sharp_peaks_are_resolved() -> None:
    """Damping ratios of 1e-4 and 1e-6: of 600 even points none would come near. Peaks are found to 1e-9."""
    k1, k2 = math.sqrt(2e4 / 5), math.sqrt(8e4 / 5)
    b1, b2 = 2e-4 * 5 * k1, 2e-6 * 5 * k2
    s = run(Response(), machine(stiffness=[2e4, 8e4], damping=[b1, b2])).wucht.summary
    assert len(s["peaks"]) == 2
    for peak, k, b in zip(s["peaks"], (k1, k2), (b1, b2), strict=True):
        sigma = b / 10
        alone = k**2 / math.sqrt(k**2 - 2 * sigma**2)
        assert peak["speed"] == pytest.approx(alone, rel=1e-7)  # but for the other direction's share
        assert peak["amplitude"] == pytest.approx(0.02 / 5 * k / (2 * sigma), rel=1e-2)
    assert s["peak_amplitude"] == s["peaks"][1]["amplitude"]


def test_peaks_are_exact() -> None:
    """The slope of the amplitude vanishes there: by central differences in higher precision."""
    import mpmath

    k, b, m, u = 2e4, 40.0, 5.0, 0.02
    with mpmath.workdps(40):

        def amplitude(w: Any) -> Any:
            z = [u * w**2 / (c - m * w**2 + 1j * w * d) for c, d in ((k, b), (3 * k, 2 * b))]
            y = -1j * z[1]
            return (abs(z[0] + 1j * y) + abs(z[0] - 1j * y)) / 2

        result = run(Response(), machine(stiffness=[k, 3 * k], damping=[b, 2 * b])).wucht.summary["peaks"]
        for peak in result:
            exact = mpmath.findroot(lambda w: mpmath.diff(amplitude, w), peak["speed"])
            assert peak["speed"] == pytest.approx(float(exact), rel=1e-11)
            assert peak["amplitude"] == pytest.approx(float(amplitude(exact)), rel=1e-12)
    assert len(result) == 2


def test_a_backward_whirl_between_two_critical_speeds() -> None:
    k1, k2 = math.sqrt(2e4 / 5), math.sqrt(8e4 / 5)
    result = run(Response(), machine(stiffness=[2e4, 8e4], damping=[1.0, 1.0]))
    inside = (result.speed > 1.02 * k1) & (result.speed < 0.98 * k2)
    assert (result.minor_axis.values[inside] < 0).all()
    assert (result.minor_axis.values[(result.speed < 0.98 * k1) | (result.speed > 1.02 * k2)] > 0).all()
    assert (np.abs(result.minor_axis) <= result.amplitude).all()
    assert "between" not in result.wucht.summary["sentence"]


@pytest.mark.parametrize(
    ("free", "relation"), [(10.0, "below"), (-90.0, "between"), (90.0, "between"), (200.0, "above"), (-200.0, "above")]
)
def test_a_drive_of_either_sense_runs_below_between_or_above_the_critical_speeds(free: float, relation: str) -> None:
    m = machine(drive=LINEAR | {"no_load_speed": free}, stiffness=[2e4, 8e4])
    sentence = run(Response(points=20), m).wucht.summary["sentence"]
    assert sentence.startswith(f"2 critical speeds in the range; the drive runs {relation} them; in operation: ")


def test_without_damping() -> None:
    result = run(Response(), machine(damping=0.0))
    s = result.wucht.summary
    assert s["peak_amplitude"] is None
    assert s["peak_speed"] == pytest.approx(K, rel=1e-12)
    assert s["peaks"] == [{"speed": pytest.approx(K, rel=1e-12), "amplitude": None}]
    assert (s["peak_torque"], s["peak_torque_speed"], s["torque_peaks"]) == (0.0, None, [])
    assert float(result.amplitude.max()) < 1e7
    assert result.wucht.warnings == ["the resonance at 63.246 rad/s (604 rpm) is undamped: there the amplitude is infinite"]
    for lag in result.lag.values:
        assert lag == pytest.approx(np.where(result.speed < K, 0.0, math.pi), abs=1e-8)
    assert "infinite at most" in "".join(report(result))
    assert 5 < draw(result).axes[0].get_ylim()[1] < 200, "mm; the samples by the resonance reach metres"


@pytest.mark.slow
def test_undamped_in_one_direction() -> None:
    s = run(Response(), machine(stiffness=[2e4, 8e4], damping=[40.0, 0.0])).wucht.summary
    assert [p["amplitude"] is None for p in s["peaks"]] == [False, True]
    assert s["peak_torque_speed"] == pytest.approx(K, rel=0.01)


def test_at_an_undamped_resonance_in_operation() -> None:
    at_resonance = machine(drive={"kind": "constant-speed", "speed": K}, damping=0.0)
    s = run(Response(), at_resonance).wucht.summary
    assert (s["amplitude_at_free_speed"], s["throw_at_free_speed"]) == (None, None)


def test_the_throw_in_operation() -> None:
    s = run(Response(), machine()).wucht.summary
    throw, w = s["throw_at_free_speed"], s["free_speed"]
    assert throw["stroke"] == pytest.approx(2 * s["amplitude_at_free_speed"], rel=1e-9), "the rotor is in the centre of mass"
    assert throw["machine_number"] == pytest.approx(s["amplitude_at_free_speed"] * w**2 / 9.80665, rel=1e-9)
    assert throw["throw_ratio"] == pytest.approx(1.0)
    assert run(Response(), load_machine("drozdetskaya-2020/table-5.1")).wucht.summary["throw_at_free_speed"] is None


def with_balls(damping: float = 40.0, eccentricity: float = 0.01, **more: Any) -> Machine:
    """Two balls that carry half of the unbalance, or, where that is small, all of it."""
    ball = {"kind": "pendulum", "about": "drum", "mass": 0.05, "length": 0.1, "damping": 1e-3} | more
    rotor = ROTOR | {"inertia": 0.5, "eccentricity": eccentricity}
    return machine([rotor, *(ball | {"name": name} for name in "pq")], damping=damping)


@pytest.mark.slow
def test_the_largest_of_all_configurations_is_where_bodies_are_stable() -> None:
    result = run(Response(), with_balls())
    s, lines = result.wucht.summary, report(result)
    stable = result.stable.values.astype(bool)
    for number, curve in (("peak_amplitude", result.amplitude), ("peak_torque", result.vibration_torque)):
        assert s[number] == np.where(stable, curve.values, 0.0).max() < np.nanmax(curve.values)
    by_configuration = {m["configuration"]: m["stable"] for m in s["peaks"]}
    assert by_configuration == {"opposed": False, "together, light side": True, "together, heavy side": False}
    assert result.peak_configuration.values.tolist() == list(by_configuration)
    there = np.interp(s["free_speed"], result.speed.values, np.where(stable, result.amplitude.values, 0.0).max(axis=0))
    assert s["amplitude_at_free_speed"] == pytest.approx(there, rel=1e-3)
    assert s["configurations_at_free_speed"] == ["together, light side"]
    assert lines[4].endswith(" in stable steady phases") and not any(line.startswith("  also") for line in lines)
    assert ", together, light side" in lines[5] and "bodies stable there: together, light side" in s["sentence"]


def test_bodies_of_a_track_are_not_in_each_others_place() -> None:
    """Balls that could hold the unbalance do so where both are stable, and not where they would be in one place."""
    result = run(Response(), with_balls(eccentricity=1e-4, track="t", diameter=0.02))
    assert (result.stable.values.astype(bool) & (result.overlapping.values == 1)[:, None]).any()
    assert (result.wucht.summary["peak_amplitude"], result.wucht.summary["peak_speed"]) == (0.0, None)
    assert report(result)[4] == "  amplitude    none in stable steady phases"


@pytest.mark.slow
def test_an_infinite_amplitude_counts_where_bodies_are_stable() -> None:
    """The resonance of a configuration in which no machine stays is no largest amplitude."""
    s = run(Response(), with_balls(damping=0.0)).wucht.summary
    assert [m["amplitude"] for m in s["peaks"]] == [None] * 3 and [m["stable"] for m in s["peaks"]].count(True) == 1
    (stable,) = [m["speed"] for m in s["peaks"] if m["stable"]]
    assert (s["peak_amplitude"], s["peak_speed"]) == (None, stable)


def test_an_undamped_mode_that_nothing_excites() -> None:
    """A rotor in the centre of mass does not turn the carrier."""
    turning = {"directions": "xyr", "inertia": 0.4, "rotation_stiffness": 900.0, "rotation_damping": 0.0}
    result = run(Response(), machine(**turning))
    assert result.wucht.warnings == []
    assert np.isnan(result.lag.sel(direction="r")).all()
    assert len(result.wucht.summary["critical_speeds"]) == 2
    assert len(result.wucht.summary["peaks"]) == 1


def test_counter_rotating_exciters_move_the_carrier_along_a_line() -> None:
    pair = [ROTOR, ROTOR | {"name": "other"}]
    described = {"carrier": {"mass": 3.0, "stiffness": 2e4, "damping": 40.0}, "bodies": pair}
    drives = [LINEAR | {"on": "drum"}, LINEAR | {"on": "other", "no_load_speed": -250.0}]
    result = run(Response(), machine_from(described | {"drives": drives}))
    assert result.displacement_amplitude.sel(direction="y").values == pytest.approx(0)
    assert np.isnan(result.lag.sel(direction="y")).all()
    assert result.minor_axis.values == pytest.approx(0, abs=1e-15)
    assert result.torque_on_body.sum("body").values == pytest.approx(result.vibration_torque.values, rel=1e-9, abs=1e-12)
    turned = run(Response(start={"other": math.pi}), machine_from(described | {"drives": drives}))
    assert turned.displacement_amplitude.sel(direction="x").values == pytest.approx(0)


def test_balanced() -> None:
    for m, start in (
        (machine([ROTOR | {"eccentricity": 0.0}]), {}),
        (
            machine([ROTOR, {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.2, "length": 0.1}]),
            {"p": math.pi},
        ),
    ):
        s = run(Response(bodies="held", start=start), m).wucht.summary
        assert "nothing excites the carrier" in s["sentence"]
        assert (s["peaks"], s["peak_speed"], s["peak_amplitude"]) == ([], None, 0.0)
        assert s["self_centring_speed"] is None


def test_a_carrier_that_only_turns() -> None:
    rotor = {k: v for k, v in ROTOR.items() if k != "eccentricity"} | {"couple_unbalance": 1e-3}
    turning = {"directions": "r", "inertia": 0.5, "rotation_stiffness": 2e3, "rotation_damping": 2.0}
    result = run(Response(), machine_from({"carrier": turning, "bodies": [rotor], "drive": LINEAR}))
    w = result.speed.values
    exact = 1e-3 * w**2 / np.abs(2e3 - 0.5 * w**2 + 2j * w)
    assert result.amplitude.values == pytest.approx(exact, rel=1e-12)
    assert result.amplitude.attrs["units"] == "rad" and np.isnan(result.centre_distance).all()
    assert result.wucht.summary["self_centring_speed"] is None
    assert "° at most, at " in report(result)[4] and "stroke" not in "".join(report(result))
    figure = draw(result)
    assert len(figure.axes) == 3 and " ".join(figure.axes[0].get_ylabel().split()) == "amplitude of the axis (rad)"


def test_a_displacement_lags_the_force_in_its_direction() -> None:
    result = run(Response(start={"drum": 0.5}), machine(stiffness=[2e4, 8e4], damping=[40.0, 300.0]))
    w = result.speed.values
    for direction, k, b in (("x", 2e4, 40.0), ("y", 8e4, 300.0)):
        assert result.lag.sel(direction=direction).values == pytest.approx(np.arctan2(b * w, k - 5 * w**2), rel=1e-9)


def test_without_a_force_the_reference_is_the_angle_of_the_main_rotor() -> None:
    """Mounts beside the centre of mass turn the carrier, on which the unbalance exerts no moment."""
    mounts = [{"at": [x, 0.1], "stiffness": [1e4, k], "damping": [30.0, 30.0]} for x, k in ((-0.3, 1e4), (0.4, 2e4))]
    given = {"mass": 3.0, "inertia": 0.4, "directions": "xyr", "mounts": mounts}
    result = run(Response(start={"drum": 0.5}), machine_from({"carrier": given, "bodies": [ROTOR], "drive": LINEAR}))
    z = (result.displacement_real + 1j * result.displacement_imag).sel(direction="r").values
    assert np.abs(z).max() > 1e-3
    behind = np.exp(1j * (0.5 - np.angle(z) - result.lag.sel(direction="r").values))
    assert behind == pytest.approx(1.0, abs=1e-9)


def test_losses_are_reported_apart() -> None:
    m = machine([ROTOR | {"bearing_damping": 0.01}])
    result = run(Response(), m)
    assert result.loss_torque.values == pytest.approx(0.01 * result.speed.values, rel=1e-12)
    assert (result.required_torque - result.vibration_torque).values == pytest.approx(result.loss_torque.values)
    clockwise = machine([ROTOR | {"bearing_damping": 0.01}], LINEAR | {"no_load_speed": -250.0})
    assert run(Response(), clockwise).loss_torque.equals(result.loss_torque)


def test_schedules_are_done() -> None:
    """The response is that of a steady speed: with the unbalance at the end of its schedule."""
    described = {"carrier": {"mass": 3.0, "stiffness": 2e4, "damping": 40.0}, "bodies": [ROTOR], "drive": LINEAR}
    schedule = {"parameter": "drum.eccentricity", "points": [[0, 0.005], [3, 0.01]]}
    result = run(Response(), machine_from(described | {"schedules": [schedule]}))
    assert result.amplitude.equals(run(Response(), machine_from(described)).amplitude)


def test_a_machine_without_units_has_none_in_its_report() -> None:
    lines = report(run(Response(range=(0.5, 2.0), points=20), load_machine("drozdetskaya-2020/table-5.1")))
    assert lines[2] == "  range        0.5 to 2" and not any(unit in "".join(lines[2:]) for unit in ("rad/s", "mm", "N·m"))


def test_without_vibration_there_is_little_to_report_or_to_draw() -> None:
    result = run(Response(points=20), machine([ROTOR | {"eccentricity": 0.0}]))
    assert [line.split()[0] for line in report(result)[2:]] == ["range", "critical", "assumed"]
    amplitude, phase, torque = draw(result).axes
    assert not any(np.any(drawn.get_ydata()) for axis in (amplitude, torque) for drawn in axis.get_lines()[:1])
    assert phase.get_legend() is None, "what does not vibrate has no phase"
    none = report(run(Response(range=(70.0, 80.0), points=20), machine()))
    assert none[3] == "  critical     none" and none[1].startswith("verdict: no critical speeds in the range")


def test_an_exciter_does_not_centre_itself() -> None:
    """Its eccentricity is far larger than the motion of its axis, where the carrier is heavy; and two have no common centre."""
    drawn = [draw(run(Response(), machine(mass=mass, stiffness=[2e4, 6e4]))).axes for mass in (3.0, 30.0)]
    assert [any(a.get_ylabel().startswith("distance from rest") for a in axes) for axes in drawn] == [True, False]
    two = [ROTOR | {"name": f"e{k}", "position": [0.1 * k, 0.0]} for k in (1, 2)]
    carrier = {"mass": 3.0, "inertia": 0.1, "directions": "xyr", "mounts": [{"at": [0.1, 0.0], "stiffness": [2e4, 6e4]}]}
    m = machine_from({"carrier": carrier, "bodies": two, "drives": [LINEAR | {"on": f"e{k}"} for k in (1, 2)]})
    result = run(Response(bodies="held"), m)
    assert np.isfinite(result.centre_distance.values).any() and len(draw(result).axes) == 3


@pytest.mark.usefixtures("no_figures")
def test_a_file_written_for_a_run_up(wucht: Callable[..., Any], study: Callable[..., Path]) -> None:
    """Its starting phases hold, its time is dropped."""
    command = wucht("run", study(), "--set", "study.kind=response", "-o", "out", "--json")
    assert command.code == 0, command.err
    assert command.document["summary"]["critical_speeds"] == pytest.approx([math.sqrt(1e5 / 10.25)])
    with xr.open_dataset("out/result.nc", engine="h5netcdf") as result:
        assert json.loads(result.attrs["input"])["study"]["start"] == {"p1": "0.3 rad", "p2": "-0.5 rad"}
