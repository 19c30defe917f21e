"""The study ``coast-down``: against closed solutions, and how it ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from tests.refusals import refused

from interrupting import stop_at
from wucht import CoastDown, Machine, RunUp, draw, load_machine, report, run
from wucht.analysis.vibration import ForcedVibration
from wucht.files.building import machine_from

J, LOSS = 0.02, 0.004  # kg m^2, N m s


def disc(unbalance: float = 0.0, gravity: float = 0.0, **parts: dict[str, Any]) -> Machine:
    """A disc in a bearing with losses, on a fixed axis."""
    body = {"kind": "rotor", "name": "disc", "mass": 1.0, "unbalance": unbalance, "inertia": J, "bearing_damping": LOSS}
    return machine_from({"carrier": {"directions": "fixed", "gravity": gravity}, "bodies": [body]} | parts)


def heavy_body(damping: float) -> dict[str, Any]:
    return {"kind": "rotor", "name": "disc", "mass": 1.0, "unbalance": 2e-3, "inertia": J, "bearing_damping": damping}


def heavy_disc(gravity: float = 9.81) -> Machine:
    """The same with an unbalance under gravity: a pendulum once it has no more speed."""
    return disc(2e-3, gravity)


def stop_after(share: float, shares: list[float]) -> Callable[[float, str], None]:
    """One that interrupts it when more than a share is done; it collects the shares."""

    def report(done: float, _what: str) -> None:
        shares.append(done)
        if done > share:
            raise KeyboardInterrupt

    return report


AT_100 = {"disc": {"speed": 100.0}}


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_exponential_decay(sense: float) -> None:
    """omega = omega_0 exp(-b t/J): half after J ln 2/b.

    The mean speed over a turn is more than that in the middle of its time, by (pi b/(J omega))^2/6.
    """
    result = run(CoastDown(until=20.0, start={"disc": {"speed": sense * 100.0}}), disc())
    s = result.wucht.summary
    half = J / LOSS * (math.log(2) + (math.pi * LOSS / J / 50) ** 2 / 6)
    assert result.wucht.summary["half_time"] == pytest.approx(half, abs=1e-6)
    np.testing.assert_allclose(result.speed, sense * 100 * np.exp(-LOSS / J * result.time), rtol=1e-9)
    np.testing.assert_allclose(result.mean_speed[:-1], sense * 100 * np.exp(-LOSS / J * result.turn_time[:-1]), rtol=0.02)
    assert (s["outcome"], s["reversal_time"], s["end_time"]) == (None, None, 20.0)
    assert s["energy_residual"] < 1e-10
    assert s["turns"] == pytest.approx(sense * 100 * J / LOSS * (1 - math.exp(-4.0)) / (2 * math.pi))
    assert s["final_speed"] == pytest.approx(sense * 100 * J / LOSS * (math.exp(-3.6) - math.exp(-4.0)) / 2, rel=1e-2)
    fastest, slowest = (sense * 100 * math.exp(-k) for k in (3.6, 4.0))
    assert [s["min_speed"], s["max_speed"]] == pytest.approx(sorted((fastest, slowest)), rel=1e-2)
    assert (s["peak_amplitude"], s["peak_speed"], s["carrier_start"]) == (0.0, None, "fixed")
    assert not any("carrier" in statement for statement in result.wucht.assumed)
    assert report(result)


@pytest.mark.parametrize(("loss", "is_noise"), [(1e-11, True), (1e-9, False)])
def test_work_below_the_noise_of_the_energy_is_none(loss: float, is_noise: bool) -> None:
    """1e-7 of the energy, 100 J; in 10 s the bearing takes 10^5 s times its loss."""
    result = run(CoastDown(until=10.0, start=AT_100), disc(bodies=[heavy_body(loss)]))
    assert (float(np.abs(result.dissipated_work).max()) == 0.0) is is_noise


def test_without_until_it_ends_at_a_hundredth() -> None:
    result = run(CoastDown(start=AT_100), disc()).wucht.summary
    assert result["end_time"] >= J / LOSS * math.log(100)
    assert abs(result["final_speed"]) < 2.0


def test_long_runs_keep_few_rows() -> None:
    result = run(CoastDown(start={"disc": {"speed": 1e4}}), disc())
    assert result.sizes["time"] <= 8000
    assert (np.diff(result.time) > 0).all()
    assert result.wucht.summary["half_time"] == pytest.approx(J / LOSS * math.log(2), rel=1e-6)


def test_of_rows_that_become_one_the_extremes_stay() -> None:
    """A heavy disc is faster below than above in each turn: however few rows are kept, each bounds all of its time."""
    every, few = (run(CoastDown(until=until, start={"disc": {"speed": 8e3}}), heavy_disc()) for until in (1.0, 8.0))
    time, of_few = every.time.values, few.time.values
    assert (of_few < 1.0).sum() < len(time) / 1.5
    row = np.searchsorted(of_few, time[1:] - 1e-9)
    is_within = of_few[row - 1] <= time[:-1] + 1e-9
    row, least, greatest = row[is_within], every.min_speed.values[1:][is_within], every.max_speed.values[1:][is_within]
    assert (few.min_speed.values[row] <= least + 1e-6).all()
    assert (few.max_speed.values[row] >= greatest - 1e-6).all()


def test_coulomb_friction_stops_it() -> None:
    result = run(CoastDown(until=60.0, start=AT_100), disc(load={"kind": "coulomb", "torque": 0.05})).wucht.summary
    # J w' = -b w - M_c from w_0: w = 0 at (J/b) ln(1 + b w_0/M_c)
    assert result["half_time"] == pytest.approx(J / LOSS * math.log((LOSS * 100 + 0.05) / (LOSS * 50 + 0.05)), rel=1e-4)
    assert result["outcome"] == "stopped"


def test_it_starts_with_the_speed_of_its_drive() -> None:
    driven = disc(drive={"kind": "linear", "slope": 0.036, "no_load_speed": 100.0})
    result = run(CoastDown(until=1.0), driven)
    assert result.wucht.summary["start_speed"] == pytest.approx(90.0)  # slope (100 - w) = b w
    assert float(result.speed[-1]) == pytest.approx(90 * math.exp(-LOSS / J), rel=1e-9)


def test_a_prescribed_speed_is_let_go() -> None:
    result = run(CoastDown(until=1.0), disc(drive={"kind": "constant-speed", "speed": 80.0}))
    assert float(result.speed[-1]) == pytest.approx(80 * math.exp(-LOSS / J), rel=1e-9)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_heavy_disc_turns_back_and_swings(sense: float) -> None:
    result = run(CoastDown(until=60.0, start={"disc": {"angle": math.pi / 2, "speed": sense * 20.0}}), heavy_disc())
    summary = result.wucht.summary
    assert summary["outcome"] in ("oscillating", "stopped")
    at = summary["reversal_time"]
    assert 0 < at < 60.0
    time, speed = result.time.values, result.speed.values
    first = int(np.flatnonzero(sense * speed < 0)[0])
    assert time[first - 1] <= at <= time[first]
    assert summary["half_time"] < at
    assert report(result)
    axis = draw(result).axes[0]
    marks = {str(line.get_label()): line.get_xydata().tolist() for line in axis.get_lines()}
    assert marks["turns back"] == [[at, 0.0]] and marks["speed halved"] == [[summary["half_time"], sense * 10.0]]
    starts = [line.get_xdata()[0] for line in axis.get_lines() if len(line.get_xdata()) > 5]
    assert max(starts) == time[time >= float(result.turn_time[-1])][0], (
        "between the last whole turn and the reversal there is no gap"
    )


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_speed_at_the_end_is_that_since_it_turned_back(sense: float) -> None:
    question = {"start": {"disc": {"angle": math.pi / 2, "speed": sense * 20.0}}}
    at = run(CoastDown(until=60.0, **question), heavy_disc()).wucht.summary["reversal_time"]
    result = run(CoastDown(until=1.02 * at, **question), heavy_disc())
    back = result.time.values >= at
    duration = float(result.time[-1] - result.time[back][0])
    mean = float(result.angle[-1] - result.angle[back][0]) / duration
    assert result.wucht.summary["final_speed"] == pytest.approx(mean, rel=1e-9) and sense * mean < 0


@pytest.mark.parametrize("until", [None, 100.0])
@pytest.mark.parametrize(("damping", "outcome"), [(LOSS, "stopped"), (0.0, "oscillating")])
def test_the_same_motion_has_the_same_outcome_through_both_doors(until: float | None, damping: float, outcome: str) -> None:
    """A swing that can only lose energy is ``stopped``, however large it still is; one without losses is not."""
    heavy = disc(2e-3, 9.81, bodies=[heavy_body(damping)])
    start = {"disc": {"angle": -math.pi / 2, "speed": 20.0 if damping else 1.2}}
    down = run(CoastDown(until=until, start=start), heavy)
    up = run(RunUp(until=until, start=start), heavy)
    assert down.attrs["outcome"] == up.attrs["outcome"] == outcome
    assert down.attrs["sentence"].partition(";")[0] == up.attrs["sentence"]


def test_where_a_swing_may_yet_die_out_it_says_how_long_to_run() -> None:
    """As the run-up of the same motion does."""
    heavy = disc(2e-3, 9.81, bodies=[heavy_body(LOSS)])
    start = {"disc": {"angle": -math.pi / 2, "speed": 20.0}}
    down, up = run(CoastDown(until=20.0, start=start), heavy), run(RunUp(until=20.0, start=start), heavy)
    assert (down.wucht.summary["outcome"], up.attrs["outcome"]) == (None, "unidentified")
    assert down.wucht.warnings == [up.wucht.summary["advice"]]


@pytest.mark.parametrize(("share", "outcome"), [(0.97, "oscillating"), (1.03, None)])
def test_an_undamped_disc_swings_below_the_speed_at_which_it_turns_over(share: float, outcome: str | None) -> None:
    """From its lowest place it turns over at J w^2/2 = 2 U g; a run-up calls what turns on by another name."""
    heavy = disc(2e-3, 9.81, bodies=[heavy_body(0.0)])
    speed = share * 2 * math.sqrt(2e-3 * 9.81 / J)
    start = {"disc": {"angle": -math.pi / 2, "speed": speed}}
    assert run(CoastDown(until=100.0, start=start), heavy).wucht.summary["outcome"] == outcome
    up = run(RunUp(until=100.0, start=start), heavy).attrs["outcome"]
    assert (up == "oscillating") == (outcome == "oscillating")


@pytest.mark.slow
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_speed_of_the_largest_amplitude_is_the_mean_over_the_turn_about_it(sense: float) -> None:
    """A light, heavily unbalanced rotor is slower and faster within a turn; against an integration of our own."""
    mass, unbalance, inertia, stiffness, damping = 5.0, 0.05, 0.02, 5e3, 8.0

    def rates(_: float, s: np.ndarray) -> list[float]:
        x, v, angle, speed = s
        matrix = [[mass, -unbalance * math.sin(angle)], [-unbalance * math.sin(angle), inertia]]
        forces = [unbalance * speed**2 * math.cos(angle) - damping * v - stiffness * x, -0.004 * speed]
        return [v, (a := np.linalg.solve(matrix, forces))[0], speed, a[1]]

    own = solve_ivp(rates, (0, 8), [0, 0, 0, sense * 60.0], "DOP853", np.linspace(0, 8, 160_001), rtol=1e-11, atol=1e-12)
    time, (x, _, angle, speed) = own.t, own.y
    top = int(np.abs(x).argmax())
    turns = sense * angle
    eighth = math.floor(turns[top] / (math.pi / 4))  # turns begin at each eighth of one: this one has it in its middle
    begin, end = (np.interp((eighth + k) * math.pi / 4, turns, time) for k in (-3, 5))
    body = {"kind": "rotor", "name": "r", "mass": 4.0, "unbalance": unbalance, "inertia": inertia, "bearing_damping": 0.004}
    machine = machine_from({
        "carrier": {"mass": 1.0, "directions": "x", "stiffness": stiffness, "damping": damping}, "bodies": [body],
    })  # fmt: skip
    start = {"r": {"speed": sense * 60.0}}
    s = run(CoastDown(until=8.0, start=start, vibration="none"), machine).wucht.summary
    assert s["peak_amplitude"] == pytest.approx(np.abs(x).max(), rel=1e-5)
    assert s["peak_speed"] == pytest.approx(sense * 2 * math.pi / (end - begin), rel=1e-6)
    assert abs(speed[top]) != pytest.approx(abs(s["peak_speed"]), rel=0.01), "not that of the instant"


def test_half_of_less_than_a_turn() -> None:
    result = run(CoastDown(until=20.0, start={"disc": {"speed": 0.5}}), disc()).wucht.summary
    assert result["half_time"] == pytest.approx(J / LOSS * math.log(2), rel=1e-3)


@pytest.mark.parametrize("call", [1, 2])
def test_an_interrupted_run_is_a_valid_result(call: int) -> None:
    result = run(CoastDown(until=1000.0, start=AT_100), disc(), progress=stop_at(call))
    assert result.attrs["finished"] == 0
    assert result.sizes["time"] >= 1
    assert any("interrupted" in w for w in result.wucht.warnings)


@pytest.mark.slow
@pytest.mark.parametrize(("swinging", "share"), [(False, 0.0), (True, 0.1), (True, 0.97)])
def test_resumed_it_is_the_uninterrupted_one(tmp_path: Path, share: float, swinging: bool) -> None:
    """From the folder, to the last bit: it continues from the last whole leg."""
    machine, question = heavy_disc() if swinging else disc(), CoastDown(until=250.0, start=AT_100)
    asked: list[float] = []
    whole = run(question, machine, progress=lambda share, _: asked.append(share))
    broken = run(question, machine, folder=tmp_path, progress=stop_at(1 + int(share * len(asked))))
    assert broken.attrs["finished"] == 0
    seen: list[float] = []
    again = run(question, machine, folder=tmp_path, resume=True, progress=lambda share, _: seen.append(share))
    xr.testing.assert_equal(again, whole)
    assert again.wucht.summary == whole.wucht.summary
    assert again.attrs["finished"] == 1
    assert again.wucht.warnings == whole.wucht.warnings
    if share >= 0.5:
        assert min(seen) > share - 0.25, "of five legs only the one that was interrupted is run again"


@pytest.mark.slow
@pytest.mark.parametrize("swinging", [False, True])
def test_what_is_remembered_of_a_long_run_is_small(tmp_path: Path, swinging: bool) -> None:
    """Of a rotor that creeps or swings on, too: times, angles and speeds of its 16 legs are 8 MB."""
    machine, stop = heavy_disc() if swinging else disc(), stop_after(0.9, [])
    run(CoastDown(until=1000.0, start=AT_100), machine, folder=tmp_path, progress=stop)
    units = [f for f in (tmp_path / "units").rglob("*") if f.is_file()]
    assert units
    assert sum(f.stat().st_size for f in units) < 3_000_000


@pytest.mark.slow
def test_the_implicit_integrator_agrees() -> None:
    times = [
        run(CoastDown(until=5.0, start=AT_100, engine=engine), heavy_disc()).wucht.summary["half_time"]
        for engine in (None, "radau")
    ]
    assert times[0] == pytest.approx(times[1], rel=1e-9)


# How the carrier starts

SHAKEN = {
    "carrier": {"mass": 20.0, "directions": "xy", "stiffness": [8e4, 2e5], "damping": [60.0, 90.0], "gravity": 9.81},
    "bodies": [
        {"kind": "rotor", "name": "r", "mass": 2.0, "unbalance": 0.01, "inertia": 2.0, "bearing_damping": 1e-4},
        {"kind": "pendulum", "name": "p", "about": "r", "mass": 0.05, "length": 0.1, "damping": 10.0},
    ],
}


@pytest.mark.parametrize("speed", [300.0, -300.0])
def test_it_starts_in_the_steady_vibration_of_its_speed(speed: float) -> None:
    """As heavy as this rotor is, it goes on turning like that; from rest a free vibration is added, which decays."""
    machine, start = machine_from(SHAKEN), {"r": {"angle": 0.4, "speed": speed}, "p": 1.1}
    steady = run(CoastDown(until=0.5, start=start), machine)
    expected = float(ForcedVibration.of(machine, np.array([0.4, 1.5])).amplitude(np.array([abs(speed)]))[0][0])
    late = steady.amplitude.values[steady.sizes["time"] // 2 :]
    assert [float(steady.amplitude[0]), late.max()] == pytest.approx([expected] * 2, rel=5e-3)
    assert steady.wucht.summary["peak_amplitude"] == pytest.approx(expected, rel=5e-3)
    assert steady.wucht.summary["carrier_start"] == "steady"
    rest = run(CoastDown(until=0.5, start=start, vibration="none"), machine)
    assert rest.wucht.summary["peak_amplitude"] > 1.5 * expected
    assert any("starts at rest" in w for w in rest.wucht.warnings) and "starts at rest" not in steady.attrs["warnings"]


def test_a_start_of_the_carrier_that_is_given_stays() -> None:
    machine, start = machine_from(SHAKEN), {"r": {"speed": 300.0}, "carrier": {"x": 1e-3}}
    (plan,), _ = CoastDown(start=start).prepare(machine)
    (rest,), _ = CoastDown(start={"r": {"speed": 300.0}}, vibration="none").prepare(machine)
    assert plan.initial - rest.initial == pytest.approx([1e-3 * (n == "carrier.x") for n in machine.state_names], abs=1e-15)


def test_at_a_resonance_without_damping_it_says_so() -> None:
    machine = machine_from(SHAKEN | {"carrier": {"mass": 17.95, "directions": "x", "stiffness": 2e5}})
    with refused("study.vibration", given=None):
        CoastDown(start={"r": {"speed": 100.0}}).prepare(machine)
    CoastDown(start={"r": {"speed": 100.0}}, vibration="none").prepare(machine)


def test_two_ways_to_start_the_carrier_are_refused() -> None:
    with refused("study.vibration", "study.start.carrier", given="steady"):
        CoastDown(start={"carrier": {"x": 1e-3}}, vibration="steady")


def test_where_the_drives_would_start_the_rotors_they_start_without_them() -> None:
    """A start angle of the machine is added, one of the study stands instead; the table is as large as twice the turns."""
    screen = load_machine("practice/screen")
    first, second = (r.name for r in screen.rotors[:2])
    turned = screen.with_fields(start_angles={first: 0.3, second: -0.4})
    rows = [turned.row(turned.body(name).coordinate.position) for name in (first, second)]
    (one,), _ = CoastDown(until=0.02, bodies="held").prepare(turned)
    (other,), _ = CoastDown(until=0.02, start={second: {"angle": 0.1}}, bodies="held").prepare(turned)
    assert one.initial[rows] == pytest.approx([0.3, -0.4])
    assert other.initial[rows] == pytest.approx([0.3, 0.1])


# A run from each configuration


def test_every_run_is_in_the_summary_and_over_one_time() -> None:
    machine = load_machine("sperling-vibration/self-synchronisation-soft")
    result = run(CoastDown(until=4.0), machine)
    s, both = result.wucht.summary, ["together", "opposed"]
    assert [row["configuration"] for row in s["configurations"]] == result.configuration_name.values.tolist() == both
    first, second = s["configurations"]
    for key in ("start_speed", "half_time", "end_time", "peak_amplitude", "peak_speed", "outcome"):
        assert first[key] == s[key], key
    assert (first["start_speed"], second["start_speed"]) == (pytest.approx(5.98, abs=0.05), pytest.approx(12.0, rel=1e-3))
    assert [row["reached_from_rest"] for row in s["configurations"]] == [s["reached_from_rest"], not s["reached_from_rest"]]
    np.testing.assert_array_equal(result.run_time, result.time)
    np.testing.assert_array_equal(result.run_speed[0], result.speed)
    assert float(result.run_speed[1, 0]) == second["start_speed"]
    assert report(result) and len(draw(result).axes) == 2
    cases, _ = prepared = CoastDown(until=4.0).prepare(machine)
    turns = sum(case.start_speed * 4.0 / (2 * math.pi) for case in cases)
    assert CoastDown(until=4.0).stored_numbers(prepared) == pytest.approx(2 * turns)


def test_of_an_interrupted_study_the_runs_so_far() -> None:
    machine = load_machine("sperling-vibration/self-synchronisation-soft")
    result = run(CoastDown(until=4.0), machine, progress=stop_after(0.2, []))
    assert [row["configuration"] for row in result.wucht.summary["configurations"]] == ["together"]
    assert "run_speed" not in result and report(result)


@pytest.mark.parametrize(("share", "count"), [(1 / 1.04, 2), (1 / 1.06, 1), (-1 / 1.04, 2), (-1 / 1.06, 1), (0.4, 0)])
def test_only_natural_frequencies_that_are_passed_are_marked(share: float, count: int) -> None:
    """On the side of the speed."""
    parts = SHAKEN | {"bodies": SHAKEN["bodies"][:1]}
    speed = share * math.sqrt(2e5 / 22)
    axis = draw(run(CoastDown(until=0.1, start={"r": {"speed": speed}}), machine_from(parts))).axes[0]
    levels = [line.get_ydata()[0] for line in axis.get_lines() if line.get_linestyle() == ":"]
    assert len(levels) == count and all(math.copysign(1, level) == math.copysign(1, share) for level in levels)
