"""The study ``torque-balance``: working points of every kind of drive, found all, with their slopes; refusals; the command."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.refusals import Refusal, refused

from wucht import Machine, TorqueBalance, draw, load_machine, report, run
from wucht.analysis.vibration import Vibration
from wucht.files.building import machine_from
from wucht.machines.operation import net_torque

ROTOR = {"kind": "rotor", "name": "fan", "mass": 20.0, "eccentricity": 8e-3, "inertia": 0.6, "bearing_damping": 0.002}
INDUCTION = {
    "kind": "induction", "voltage": 230, "frequency": 50, "pole_pairs": 2, "stator_resistance": 2, "rotor_resistance": 1.5,
    "stator_reactance": 3, "rotor_reactance": 3,
}  # fmt: skip
SERIES = {
    "kind": "dc-series", "voltage": 24, "armature_resistance": 2, "field_resistance": 1, "field_inductance": "0.1 H",
    "motor_constant": 1.5,
}  # fmt: skip
FAN = {"kind": "quadratic", "coefficient": 6e-4}
AWAY = "without vibration the drive's torque never meets the load: the rotor would run away"


def machine(drive: Any = INDUCTION, loads: Any = (FAN,), bodies: Any = (ROTOR,), **carrier: Any) -> Machine:
    given = {"mass": 60.0, "stiffness": 1e6, "damping": 300.0} | carrier
    described: dict[str, Any] = {"carrier": {k: v for k, v in given.items() if v is not None}, "bodies": list(bodies)}
    described |= {"loads": [x for x in loads if x]} if loads else {}
    return machine_from(described | ({"drive": drive} if drive else {}))


CARRIER_OF_TABLE = load_machine("drozdetskaya-2020/table-3.1-carrier", {"u": 2})


def summary(m: Machine, **question: Any) -> dict[str, Any]:
    return run(TorqueBalance(**question), m).wucht.summary


@pytest.mark.parametrize(("bearing", "sense"), [(0.0, -1), (1e-9, 1)])
def test_the_default_range_reaches_what_the_vibration_holds_far_beyond_the_resonance(bearing: float, sense: int) -> None:
    """A constant torque: the vibration torque of a light damper, c w (U/M)^2/2, is as large only at 1276 rad/s."""
    rotor = {
        "kind": "rotor",
        "name": "r",
        "mass": 0.096,
        "eccentricity": 0.0592,
        "inertia": 5.5394e-4,
        "bearing_damping": bearing,
    }
    carrier = {"mass": 1.3608, "directions": "x", "stiffness": 186.3, "damping": 0.659}
    s = summary(machine({"kind": "constant-torque", "torque": sense * 6.4e-3}, None, [rotor], **carrier))
    fastest = max(s["working_points"], key=lambda p: abs(p["speed"]))
    held = 2 * 6.4e-3 / 0.659 / (0.096 * 0.0592 / 1.4568) ** 2
    if not bearing:
        assert s["sentence"].startswith(f"{AWAY}; with it are 3 working points, 2 of them stable")
    assert fastest["stable"]
    assert fastest["speed"] == pytest.approx(sense * held, rel=2e-3)
    assert sorted(map(abs, s["range"])) == pytest.approx([0.0, 1.2 * abs(fastest["speed"])])
    assert len(s["working_points"]) == 3


def test_an_induction_motor_drives_a_fan_through_a_resonance() -> None:
    m = machine()
    s, vibration, left = summary(m), Vibration.of(m), net_torque(m, m.rotor)
    points = s["working_points"]
    assert [p["stable"] for p in points] == [True, False, True]

    def surplus(w: float) -> float:
        return left(w) - float(vibration.torque(np.array([w]), np.zeros(1))[0][0])

    (motor,) = m.drives
    grid = np.linspace(1.0, s["range"][1], 2001)
    signs = np.sign([surplus(w) for w in grid])
    exact = [brentq(surplus, grid[i], grid[i + 1], xtol=1e-13) for i in np.flatnonzero(np.diff(signs))]
    assert [p["speed"] for p in points] == pytest.approx(exact, rel=1e-11)
    for p in points:
        assert (p["slope"], p["no_load_speed"]) == pytest.approx(motor.linearisation(p["speed"]), rel=1e-12)
        assert p["torque"] == pytest.approx(motor.torque_at(p["speed"]), rel=1e-12)
        assert p["slip"] == pytest.approx(1 - p["speed"] / (50 * math.pi), rel=1e-12)
    slip, speed, torque = motor.breakdown()  # type: ignore[attr-defined]
    assert s["breakdown"] == pytest.approx({"slip": slip, "speed": speed, "torque": torque})
    assert s["free_speed"] == pytest.approx(brentq(left, 130.0, 157.0), rel=1e-11)
    assert not s["runaway"]


@pytest.mark.parametrize(
    ("speeds", "sentence"),
    [
        ((1.0, 1.2), "one working point, not stable"),
        ((0.1, 0.2), "drive, load and vibration do not balance anywhere in the range"),
    ],
)
def test_a_range_without_a_stable_point(speeds: tuple[float, float], sentence: str) -> None:
    assert summary(CARRIER_OF_TABLE, range=speeds)["sentence"] == sentence


def test_bodies_of_a_track_are_not_in_each_others_place() -> None:
    """Such points are counted, and have a line only where there are no others; in the figure they are crosses."""
    drum = {"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": 4e-3, "inertia": 0.05}
    ball = {"kind": "pendulum", "about": "drum", "mass": 0.05, "length": 0.1, "damping": 1e-3, "track": "t", "diameter": 0.02}
    drive = {"kind": "linear", "slope": 0.05, "no_load_speed": 100.0}
    m = machine(drive, (), [drum, *(ball | {"name": name} for name in "pq")], mass=10.0, stiffness=4e4, damping=60.0)
    result = run(TorqueBalance(), m)
    s, lines = result.wucht.summary, report(result)
    count = "2 working points, 1 of them stable: compensating; 2 more with overlapping bodies of a track"
    assert s["sentence"] == f"{count}; reached from rest"
    crossed = sorted(p["speed"] for p in s["working_points"] if p["overlapping"])
    assert len(crossed) == 2 == result.point_overlapping.values.sum()
    assert sum(x.startswith(("  stable", "  unstable")) for x in lines) == 2 and "overlapping" not in "".join(lines[2:])
    crosses = [x.get_xdata().tolist() for x in draw(result).axes[0].get_lines() if x.get_marker() == "x"]
    assert np.sort(np.concatenate(crosses)) == pytest.approx(crossed)
    alone = run(TorqueBalance(range=(0.0, crossed[0] + 1e-3)), m)
    assert "do not balance anywhere in the range in any steady phases" in alone.attrs["sentence"]
    assert ", but with overlapping bodies of a track: " in report(alone)[2]


def test_rotors_that_do_not_run_synchronously() -> None:
    m = pair_of_exciters()
    s = summary(m, range=(92.5, 93.5))
    assert [p["stable"] for p in s["working_points"]] == [False]
    words = "the rotors do not run synchronously: no synchronous configuration in the range is stable"
    assert s["sentence"] == f"{words} (1 not stable)"
    assert summary(m, range=(1.0, 2.0))["sentence"] == words


def test_a_schedule_changes_the_breakdown() -> None:
    m = machine_from(
        {"carrier": {"stiffness": 1e6}, "bodies": [ROTOR], "drive": INDUCTION,
         "schedules": [{"parameter": "drive.voltage", "points": [[0, 115], [1, 230]]}]}
    )  # fmt: skip
    whole = summary(machine(loads=()))["breakdown"]
    assert summary(m)["breakdown"]["torque"] == pytest.approx(whole["torque"])  # a steady study: with its schedules done
    assert summary(m.at(0.5))["breakdown"]["torque"] == pytest.approx(whole["torque"])


@pytest.mark.slow
def test_a_series_motor_without_load_runs_away() -> None:
    """002 (2.105)."""
    bodies = [ROTOR | {"bearing_damping": 0.0}]
    result = run(TorqueBalance(), machine(SERIES, (), bodies, directions="fixed", stiffness=None, damping=0.0))
    s = result.wucht.summary
    assert [result[f"point_{n}"].dtype.kind for n in ("speed", "torque", "stable")] == ["f", "f", "i"], "empty, and as ever"
    assert (s["runaway"], s["free_speed"], s["working_points"], s["sentence"]) == (True, None, [], AWAY)
    on_springs = summary(machine(SERIES, (), bodies))
    assert on_springs["runaway"] and [p["stable"] for p in on_springs["working_points"]] == [True], "the resonance holds it"
    assert not summary(machine(SERIES))["runaway"]
    assert summary(machine(SERIES | {"sense": -1}, (), bodies))["runaway"]


def test_a_constant_torque_without_losses_runs_away() -> None:
    drive = {"kind": "constant-torque", "torque": 0.5}
    still = {"directions": "fixed", "stiffness": None, "damping": 0.0}
    assert summary(machine(drive, (), [ROTOR | {"bearing_damping": 0.0}], **still))["runaway"]
    held = summary(machine(drive, (), **still))
    assert not held["runaway"]
    assert held["working_points"][0]["speed"] == pytest.approx(250.0)
    assert held["working_points"][0]["no_load_speed"] is None


def test_clockwise_is_the_mirror_image() -> None:
    linear = {"kind": "linear", "slope": 0.4, "no_load_speed": 150.0}
    first, second = summary(machine(linear)), summary(machine(linear | {"no_load_speed": -150.0}))
    forward, backward = first["working_points"], second["working_points"][::-1]
    assert forward
    assert [-p["speed"] for p in backward] == pytest.approx([p["speed"] for p in forward])
    assert [p["stable"] for p in backward] == [p["stable"] for p in forward]
    assert [-p["torque"] for p in backward] == pytest.approx([p["torque"] for p in forward])
    assert second["range"] == pytest.approx([-first["range"][1], 0.0], rel=1e-12)


def test_all_four_quadrants() -> None:
    result = run(TorqueBalance((-200.0, 200.0)), machine())
    even = np.interp(-result.speed.values, result.speed.values, result.vibration_torque.values)
    assert result.vibration_torque.values == pytest.approx(-even, abs=0.01 * even.max())
    assert np.sign(result.vibration_torque.values) == pytest.approx(np.sign(result.speed.values))


def slope_at_the_fold() -> float:
    """The minimum of 002 (3.52) between 1.3 and 1.6."""

    def u(w: float) -> float:
        return 0.1 * w**5 / (((1 - w**2) ** 2 + 0.04 * w**2) * (2 - w))

    low, high = 1.3, 1.6
    for _ in range(200):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        low, high = (a, high) if u(a) > u(b) else (low, b)
    return u(low)


def test_roots_closer_than_the_grid() -> None:
    """Ten points over the range, and two roots between two of them, 1e-4 apart, by the fold at u = 0.8937191."""
    m = load_machine("drozdetskaya-2020/table-3.1-carrier", {"u": slope_at_the_fold() * (1 + 1e-9)})
    points = summary(m, points=10)["working_points"]
    assert len(points) == 3
    assert 0 < points[2]["speed"] - points[1]["speed"] < 2e-4
    m = load_machine("drozdetskaya-2020/table-3.1-carrier", {"u": slope_at_the_fold() * (1 - 1e-7)})
    assert len(summary(m, points=10)["working_points"]) == 1


def test_curves_that_touch() -> None:
    """At the fold itself: noted as touching, not stable."""
    u = slope_at_the_fold() * (1 - 1e-12)
    result = run(TorqueBalance(), load_machine("drozdetskaya-2020/table-3.1-carrier", {"u": u}))
    crossing, touching = result.wucht.summary["working_points"]
    assert crossing["stable"]
    assert touching["speed"] == pytest.approx(1.4239669, abs=1e-7)
    assert touching["tangential"]
    assert not touching["stable"]
    assert "only touch" in result.attrs["warnings"]


def test_phases_shift_the_working_points() -> None:
    r1 = load_machine("drozdetskaya-2020/r1-u80")
    compensated = summary(r1, bodies="held", start={"p1": math.radians(247.976), "p2": math.radians(112.024)})
    assert [p["speed"] for p in compensated["working_points"]] == pytest.approx([200.0], rel=1e-6)
    assert summary(r1, bodies="held")["working_points"][-1]["speed"] < 199.9


def moments(v: Vibration, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
    """The moment on each body by the sum over all pairs: a_ik = e_i^H H e_k,

    V_i = -(f_i/2) sum_k f_k [Re a_ik sin(alpha_i - alpha_k) - Im a_ik cos(alpha_i - alpha_k)].
    """
    result = np.zeros((len(speeds), len(phases)))
    for n, w in enumerate(speeds):
        influence = np.linalg.inv(v.stiffness - w**2 * v.mass + 1j * w * v.damping)
        for i, e_i in enumerate(v.excitation):
            for k, e_k in enumerate(v.excitation):
                a, apart = e_i.conj() @ influence @ e_k, phases[i] - phases[k]
                result[n, i] -= w**4 / 2 * (a.real * np.sin(apart) - a.imag * np.cos(apart))
    return result


def pair_of_exciters() -> Machine:
    pair = [ROTOR | {"position": [0.3, 0.0]}, ROTOR | {"name": "other", "position": [-0.2, 0.1], "bearing_damping": 0.01}]
    carrier = {"directions": "xyr", "mass": 60.0, "inertia": 8.0, "stiffness": 1e6, "damping": 300.0,
               "rotation_stiffness": 1e5, "rotation_damping": 50.0}  # fmt: skip
    drives = [
        {"on": "fan", "kind": "linear", "slope": 0.5, "no_load_speed": 150.0},
        {"on": "other", "kind": "linear", "slope": 0.3, "no_load_speed": -150.0},
    ]
    return machine_from({"carrier": carrier, "bodies": pair, "drives": drives})


def test_one_of_two_exciters() -> None:
    """Each shaft gets its own share of the vibration torque."""
    m = pair_of_exciters()
    vibration, phases = Vibration.of(m), np.array([0.2, -0.5])
    start = {"fan": 0.2, "other": 0.5}
    first, second = (run(TorqueBalance(on=on, start=start, bodies="held"), m) for on in ("fan", "other"))
    w = first.speed.values[1:]
    assert first.vibration_torque.values[1:] == pytest.approx(-moments(vibration, w, phases)[:, 0], rel=1e-9, abs=1e-12)
    w = second.speed.values[:-1]
    assert second.vibration_torque.values[:-1] == pytest.approx(moments(vibration, -w, phases)[:, 1], rel=1e-9, abs=1e-12)
    assert "all rotors are assumed to turn as fast as 'other'" in second.attrs["warnings"]


@pytest.mark.parametrize(
    ("question", "drive", "refusal"),
    [
        ({"on": "p"}, INDUCTION, refused("study.on", given="p")),
        ({"start": {"q": 1}}, INDUCTION, refused("study.start.q", code="unknown-key")),
        (
            {},
            {"kind": "constant-speed", "speed": 10.0},
            refused("machine.drive", "fan", "response", code="prescribed"),
        ),
        ({}, None, refused("machine.drive", "fan", code="no-drive")),
        ({}, INDUCTION | {"voltage": 0}, refused("machine.drive", "fan", code="no-drive")),
        ({"range": [0, 900]}, SERIES | {"voltage": 0}, refused("machine.drive", "fan", code="no-drive")),
        ({}, {"kind": "constant-torque", "torque": 0}, refused("machine.drive", "fan", code="no-drive")),
        ({}, {"kind": "linear", "slope": 0.1, "no_load_speed": 0}, refused("machine.drive", "fan", code="no-drive")),
    ],
)
def test_refused(question: dict[str, Any], drive: Any, refusal: Refusal) -> None:
    with refusal:
        run(TorqueBalance(**question), machine(drive))


# --- the command ---


@pytest.mark.parametrize(
    ("sense", "drive", "vibration", "points", "low", "high"),
    [
        # 2.5 times the drive's largest torque, however high the resonance
        (1, [10, 8, 5, 2, 0], [0, 1000, 20, 5, 1], [], 0.0, 25.0),
        # three times what opposes a motor that starts strongly
        (-1, [500, 80, 5, 2, 0], [0, 4, 2, 1, 1], [], 0.0, 12.0),
        # half of it on the other side: a drive that brakes beyond its no-load speed
        (1, [10, 8, 5, 2, -30], [0, 20, 20, 5, 1], [], -5.0, 20.0),
        # all working points are inside
        (-1, [500, 80, 5, 2, 0], [0, 4, 2, 1, 1], [3.0, -1.0], -1.0, 12.0),
        (1, [10, 8, 5, 2, 0], [0, 1000, 20, 5, 1], [30.0], 0.0, 30.0),
        # nothing opposes
        (-1, [10, 8, 5, 2, 0], [0, 0, 0, 0, 0], [], 0.0, 10.0),
        # a resonance without an end
        (1, [10, 8, 5, 2, 0], [0, np.inf, 2, np.nan, 1], [], 0.0, 6.0),
    ],
)
def test_the_drive_is_visible_however_high_the_resonance(
    sense: int, drive: list[float], vibration: list[float], points: list[float], low: float, high: float
) -> None:
    """The limits without the margins: 5 % of the height below, 8 % above. Clockwise the same upside down."""
    balance = run(TorqueBalance(), CARRIER_OF_TABLE)
    curves = {"drive_torque": drive, "load_torque": [0.0] * 5, "vibration_torque": vibration}
    order, speed = slice(None, None, sense), sense * np.linspace(0.0, 100.0, 5)
    torques = {n: ("speed", sense * np.array(v, float)[order], balance[n].attrs) for n, v in curves.items()}
    given = {
        "point_speed": [sense * 50.0] * len(points),
        "point_torque": sense * np.array(points),
        "point_stable": [1] * len(points),
    }
    result = balance.drop_dims("point").isel(speed=slice(5)).assign_coords(speed=("speed", speed[order], balance.speed.attrs))
    result = result.assign(
        stable=("speed", [1] * 5), **torques, **{n: ("point", v, balance[n].attrs) for n, v in given.items()}
    )
    (axis,) = draw(result).axes
    bottom, top = axis.get_ylim()
    height = (top - bottom) / 1.13
    expected = (low, high) if sense > 0 else (-high, -low)
    assert (bottom + 0.05 * height, top - 0.08 * height) == pytest.approx(expected)


def test_working_points_are_marked_where_they_are() -> None:
    (axis,) = draw(run(TorqueBalance(), CARRIER_OF_TABLE)).axes
    line = {str(drawn.get_label()): drawn for drawn in axis.get_lines()}
    stable, other = line["stable working point"], line["unstable working point"]
    assert list(stable.get_xdata()) == pytest.approx([0.9686444, 1.8176384], abs=1e-7)
    assert list(other.get_xdata()) == pytest.approx([1.0937039], abs=1e-7)
    assert list(other.get_ydata()) == pytest.approx([2 * (2 - 1.0937039)], abs=1e-6)
    solid, dashed = line["vibration"], line["no stable working point"]
    assert np.interp(1.0937039, dashed.get_xdata(), np.isfinite(dashed.get_ydata()).astype(float)) == 1
    assert not np.isfinite(solid.get_ydata())[np.searchsorted(solid.get_xdata(), 1.0937039)]


@pytest.mark.parametrize("speeds", [None, (1.0, 2.0)])
def test_a_torque_balance_without_vibration_or_points_can_be_drawn(speeds: tuple[float, float] | None) -> None:
    linear = {"kind": "linear", "slope": 0.05, "no_load_speed": 250.0}
    result = run(TorqueBalance(speeds), machine(linear, (), [ROTOR | {"eccentricity": 0.0, "bearing_damping": 0.0}]))
    (axis,) = draw(result).axes
    line = {str(drawn.get_label()): drawn for drawn in axis.get_lines()}
    assert not np.any(line["vibration"].get_ydata()) and ("stable working point" in line) is (speeds is None)
    assert axis.get_xlim() == (result.speed.values[0], result.speed.values[-1])


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ({"kind": "constant-torque", "torque": 0.5}, "N·m; constant torque; "),
        (
            {"kind": "inverter", "set_speed": 50.0, "gain": 1.0, "integral_time": 1.0, "torque_limit": 100.0},
            "N·m; held by the controller; ",
        ),
    ],
)
def test_what_stands_for_the_drive_at_a_working_point(drive: dict[str, Any], words: str) -> None:
    assert words in report(run(TorqueBalance(), machine(drive, bodies=[ROTOR | {"eccentricity": 0.0}])))[2]
