"""The study ``sweep``: jumps that do not depend on the rate, and sweeps that end early or do not jump."""

from __future__ import annotations

import signal
from collections.abc import Callable
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import Refusal, refused

from interrupting import assert_same, stop_at
from wucht import Sweep
from wucht.cli.progress import Progress
from wucht.dynamics.sweeps.moving import IntegrationError, Mover, Place, SweepLeg
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.runner import draw, run

OMEGA_1 = "drive.no_load_speed"
FIGURE_5 = "sperling-vibration/figure-5"


@cache
def light_rotor() -> Machine:
    """One that ripples most."""
    return load_machine(FIGURE_5, {"rotor.inertia": 1e-5})


@pytest.fixture(scope="module")
def machine() -> Machine:
    return light_rotor()


def warnings(result: xr.Dataset) -> list[str]:
    sentences: list[str] = result.wucht.warnings
    return sentences


@pytest.fixture(scope="module")
def both(machine: Machine) -> xr.Dataset:
    return run(Sweep(along=OMEGA_1, range=(5.0, 12.0)), machine)


@pytest.mark.slow
def test_both_ways_are_stored(both: xr.Dataset) -> None:
    assert list(both.direction.values) == ["up", "down"] and both.attrs["finished"] == 1
    up, down = both.sel(direction="up"), both.sel(direction="down")
    assert (np.diff(up.value) > 0).all() and (np.diff(down.value) < 0).all()
    assert both.sizes["sample"] == 400
    for name in ("value", "speed", "amplitude", "energy_residual"):
        assert np.isfinite(both[name]).all(), name
    for ramp in (up, down):
        assert ((ramp.min_speed <= ramp.speed) & (ramp.speed <= ramp.max_speed)).all()


@pytest.mark.slow
def test_the_summary_is_read_off_ramps_and_jumps(both: xr.Dataset) -> None:
    s = both.wucht.summary
    assert s["peak_amplitude"] == both.amplitude.max() and s["energy_residual"] == both.energy_residual.max()
    assert s["ends"] == {
        way: {"from_speed": float(ramp.speed[0]), "to_speed": float(ramp.speed[-1])}
        for way, ramp in ((way, both.sel(direction=way)) for way in ("up", "down"))
    }
    assert s["range"] == [5.0, 12.0] and s["rate_chosen"] is True and s["jump_tolerance"] == 1e-4
    up, down = s["jumps"]
    assert s["hysteresis"] == [down[OMEGA_1], up[OMEGA_1]]
    columns = {"value": OMEGA_1, "from": "from_speed", "to": "to_speed"} | {n: n for n in ("from_amplitude", "to_amplitude")}
    for name, key in columns.items():
        assert both[f"jump_{name}"].values.tolist() == [up[key], down[key]]
    assert both.jump_upward.values.tolist() == [1, 0]
    assert both.free_speed.values == pytest.approx(both.grid.values, rel=1e-2), "of a drive without load"
    words = [
        f"at no-load speed of the drive = {j[OMEGA_1]:.6g} rad/s {sense} the speed jumps from {j['from_speed']:.5g} to "
        f"{j['to_speed']:.5g}"
        for j, sense in zip(s["jumps"], ("rising", "falling"), strict=True)
    ]
    assert both.attrs["sentence"].split("; ") == words


def test_where_the_speed_is_prescribed_the_amplitude_jumps() -> None:
    """Beyond its stops the spring is harder, so that there are two branches. The first jump is of the rate: it is doubted."""
    rotor = {"kind": "rotor", "name": "drum", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03}
    stop = {
        "kind": "end-stop", "name": "buffer", "angle": 0.0, "gap": 3e-3, "stiffness": 5e4, "damping": 10.0, "sides": "both"
    }  # fmt: skip
    carrier = {"mass": 1.0, "stiffness": 1e5, "damping": 100.0}
    drive = {"kind": "constant-speed", "on": "drum", "speed": 90.0}
    machine = machine_from({"carrier": carrier, "bodies": [rotor], "drive": drive, "attachments": [stop]})
    result = run(Sweep(along="drive.speed", range=(90.0, 130.0), rate=8.0, direction="up"), machine)
    doubted, jump = result.wucht.summary["jumps"]
    assert jump["from_speed"] == pytest.approx(jump["to_speed"], rel=1e-4) and not jump["only_seen"]
    change = f"the amplitude jumps from {jump['from_amplitude']:.4g} to {jump['to_amplitude']:.4g}"
    assert result.attrs["sentence"].endswith(f" rising {change}") and doubted["only_seen"]
    (warning,) = warnings(result)
    assert f"the jump near {doubted['drive.speed']:.5g} is only known to lie between" in warning


def test_the_branches_part_only_between_the_jumps(both: xr.Dataset) -> None:
    low, high = both.wucht.summary["hysteresis"]
    up, down = both.sel(direction="up"), both.sel(direction="down")
    apart = np.abs(up.speed.values - np.interp(up.value, down.value[::-1], down.speed[::-1]))
    inside = (up.value.values > low) & (up.value.values < high)
    assert apart[inside].min() > 1.0
    outside = (up.value.values < low - 0.15) | (up.value.values > high + 0.15)
    assert apart[outside].max() < 0.01


def test_the_jump_does_not_depend_on_the_rate(machine: Machine, both: xr.Dataset) -> None:
    """The ramp itself jumps late: at 0.05 (rad/s)/s by more than 0.2 rad/s. What is result is the fold all the same."""
    expected = both.wucht.summary["jumps"][0]
    result = run(Sweep(along=OMEGA_1, range=(5.0, 12.0), rate=0.5, direction="up"), machine)
    (jump,) = result.wucht.summary["jumps"]
    assert jump[OMEGA_1] == pytest.approx(expected[OMEGA_1], rel=1e-4)
    for key in ("from_speed", "to_speed"):  # next to the fold the speed changes with the root of the distance
        assert jump[key] == pytest.approx(expected[key], rel=1e-3)
    ramp = result.isel(direction=0)
    late = ramp.value.values[int(np.flatnonzero(ramp.speed.values > 7.8)[0])]
    assert late > expected[OMEGA_1] + 0.2


def test_down_alone_begins_at_the_upper_end(machine: Machine) -> None:
    result = run(Sweep(along=OMEGA_1, range=(8.0, 12.0), rate=0.02, direction="down"), machine)
    assert float(result.value[0, 0]) > 11.9
    (jump,) = result.wucht.summary["jumps"]
    assert jump["direction"] == "down"
    assert jump[OMEGA_1] == pytest.approx(8.8997, rel=1e-4)
    assert result.wucht.summary["hysteresis"] is None


def test_a_strong_drive_does_not_jump(machine: Machine) -> None:
    result = run(Sweep(along=OMEGA_1, range=(5.0, 8.0), rate=0.02), machine.with_values({"drive.slope": 2e-4}))
    assert result.wucht.summary["jumps"] == []
    assert "no jump" in result.attrs["sentence"]


@pytest.mark.slow
def test_steep_is_no_jump(machine: Machine) -> None:
    """Just beyond the cusp the curve is nearly vertical, but both ways agree."""
    result = run(Sweep(along=OMEGA_1, range=(6.0, 11.0), rate=0.01), machine.with_values({"carrier.damping": 2.2}))
    assert result.wucht.summary["jumps"] == []


@pytest.mark.slow
def test_another_parameter_of_a_dimensionless_machine() -> None:
    """002, Table 3.1: the folds of the Laval rotor are at twice the u of the carrier with one direction (cases.md)."""
    result = run(Sweep(along="u", range=(1.0, 7.0), rate=2e-4), load_machine("drozdetskaya-2020/table-3.1-laval"))
    assert result.wucht.summary["rate_unit"] == "a unit of time"
    up, down = result.wucht.summary["jumps"]
    assert up["u"] == pytest.approx(2 * 2.6053860, rel=1e-4)
    assert up["from_speed"] == pytest.approx(1.0213376, rel=2e-4)
    assert down["u"] == pytest.approx(2 * 0.8937191, rel=1e-4)
    assert down["from_speed"] == pytest.approx(1.4239669, rel=1e-3)


def test_a_sweep_that_is_too_fast_says_so(machine: Machine) -> None:
    result = run(Sweep(along=OMEGA_1, range=(5.0, 12.0), rate=1.0, direction="up"), machine)
    (warning,) = [w for w in warnings(result) if "too fast" in w]
    assert "after the ramp up the speed still changed from " in warning
    assert warning.endswith("give a rate below 1 rad/s per s")


@pytest.mark.slow
def test_a_standstill_is_settled(machine: Machine) -> None:
    """What is left of a speed that dies away is small beside the speeds of the sweep, not beside itself."""
    result = run(Sweep(along=OMEGA_1, range=(0.0, 12.0), start={"rotor": {"speed": "8 rad/s"}}), machine)
    assert float(result.speed.sel(direction="down")[-1]) < 0.25  # averaged before the end of the ramp
    assert warnings(result) == []


@pytest.mark.parametrize("call", [1, 60])
def test_an_interrupted_sweep_is_a_valid_result(machine: Machine, call: int) -> None:
    result = run(Sweep(along=OMEGA_1, range=(5.0, 12.0)), machine, progress=stop_at(call))
    assert result.attrs["finished"] == 0
    assert any("interrupted" in w for w in warnings(result))
    assert result.sizes["direction"] == (0 if call == 1 else 1)
    assert result.attrs["sentence"] == "the sweep was interrupted" and draw(result).axes
    assert "the sweep is not finished: jumps may be missing" in warnings(result)
    if call == 1:
        s = result.wucht.summary
        assert (s["peak_amplitude"], s["energy_residual"], s["hysteresis"], s["ends"], s["jumps"]) == (None, None, None, {}, [])


@pytest.mark.parametrize("way", [{"direction": "up"}, {}])
def test_an_interrupted_search_for_jumps_is_a_valid_result(machine: Machine, way: dict[str, Any]) -> None:
    result = run(Sweep(along=OMEGA_1, range=(9.0, 10.5), rate=0.02, **way), machine, progress=stop_at(20, "jump"))
    assert result.attrs["finished"] == 0
    assert result.wucht.summary["jumps"] == [] and list(result.direction.values) == ["up"]
    assert np.isfinite(result.speed).all()


@cache
def there_and_back() -> tuple[Sweep, xr.Dataset, int]:
    """A quick sweep, what comes of it, and how often it asks whether to stop."""
    calls, question = list[float](), Sweep(along=OMEGA_1, range=(8.0, 10.5), rate=0.02)
    result = run(question, light_rotor(), progress=lambda share, _: calls.append(share))
    return question, result, len(calls)


@pytest.mark.slow
def test_broken_off_again_and_again(tmp_path: Path) -> None:
    """Also within the search for jumps, which is then begun again and must leave no trace; another rate is not resumed."""
    question, whole, calls = there_and_back()
    for share in (0.3, 0.15, 0.1, 0.2, 0.05):
        stop = stop_at(1 + int(share * calls))
        assert run(question, light_rotor(), folder=tmp_path, resume=True, progress=stop).attrs["finished"] == 0
    assert_same(run(question, light_rotor(), folder=tmp_path, resume=True), whole)
    seen: list[float] = []
    again = run(question, light_rotor(), folder=tmp_path, resume=True, progress=lambda share, _: seen.append(share))
    assert seen == [], "a finished sweep is not made again"
    assert_same(again, whole)
    with refused("--resume", "study.rate", "0.02", "0.03", given=None, code="other-question"):
        run(Sweep(along=OMEGA_1, range=(8.0, 10.5), rate=0.03), light_rotor(), folder=tmp_path, resume=True)


@pytest.mark.parametrize("call", [1, 30])
def test_a_sweep_that_fails_has_what_was_found_before(machine: Machine, monkeypatch: pytest.MonkeyPatch, call: int) -> None:
    """Also the legs of the unit of work that failed."""
    calls, leg = count(1), Mover.leg

    def failing(mover: Mover, place: Place, duration: float, to: float | None = None) -> SweepLeg:
        if to is not None and next(calls) == call:
            raise IntegrationError("the state is no longer finite")
        return leg(mover, place, duration, to)

    monkeypatch.setattr(Mover, "leg", failing)
    result = run(Sweep(along=OMEGA_1, range=(5.0, 12.0)), machine)
    assert int(np.isfinite(result.speed).sum()) == call - 1
    assert result.attrs["failure"] == "the state is no longer finite" and result.attrs["failure"] in warnings(result)
    assert (result.attrs["sentence"], result.attrs["finished"]) == ("the sweep failed", 0) and draw(result).axes


@pytest.mark.parametrize(
    ("table", "refusal"),
    [
        ({"along": None}, refused("study.along", code="missing")),
        (
            {"along": "drive.no_load_spede"},
            refused("study.along", "drive.no_load_speed", given="drive.no_load_spede", code="unknown-parameter"),
        ),
        ({"range": None}, refused("study.range", code="missing")),
        ({"range": ["5 kg", "12 kg"]}, refused("study.range[0]", code="dimension")),
        ({"rate": -1}, refused("study.rate", given=-1.0)),
        ({"rate": True}, refused("study.rate", given=True)),
        ({"rate": 1e-30}, refused("study.rate", given=1e-30)),
        ({"rate": 1e30}, refused("study.rate", "44 rad/s", given=1e30)),
        ({"direction": "sideways"}, refused("study.direction", code="unknown-name")),
        ({"engine": "magic"}, refused("study.engine", code="unknown-name")),
        ({"along": "rotor.mass", "range": [-1, 1]}, refused("study.range[0]", code="limits")),
        ({"along": "rotor.inertia", "range": [1e-9, 1]}, refused("study.range[0]", "m", given=1e-09)),
        ({"start": {"roter": 1}}, refused("study.start.roter", code="unknown-key")),
    ],
)
def test_bad_questions(machine: Machine, table: dict[str, Any], refusal: Refusal) -> None:
    asked = {"kind": "sweep", "along": OMEGA_1, "range": [5, 12]} | table
    with refusal:
        run(Sweep.from_table({key: value for key, value in asked.items() if value is not None}), machine)


@pytest.mark.parametrize(
    ("drive", "motion", "along", "span", "rate"),
    [
        ({"kind": "constant-speed", "speed": 60.0}, {}, "drive.speed", (60.0, 80.0), 4.0),
        (
            {"kind": "linear", "slope": 0.04, "no_load_speed": 60.0},
            {"motion": {"amplitude": 1e-4, "frequency": 30.0, "direction": "x"}},
            "carrier.motion.amplitude",
            (1e-4, 2e-4),
            1e-5,
        ),
    ],
)
def test_a_prescribed_motion_is_swept(drive: Any, motion: Any, along: str, span: tuple[float, float], rate: float) -> None:
    """Its accelerations are those of the moving value, too: else the balance of the energy would not close."""
    rotor = {"kind": "rotor", "name": "drum", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03}
    carrier = {"mass": 1.0, "stiffness": 1e5, "damping": 200.0} | motion
    swept = run(
        Sweep(along=along, range=span, rate=rate, direction="up"),
        machine_from({"carrier": carrier, "bodies": [rotor], "drive": {"on": "drum"} | drive}),
    )
    assert swept.wucht.summary["energy_residual"] < 1e-9


def test_the_rate_may_have_a_unit(machine: Machine) -> None:
    for along, span, rate, expected in (
        (OMEGA_1, ["5 rad/s", "12 rad/s"], "0.1 rad/s^2", 0.1),
        ("drive.slope", [1e-5, 1e-4], "1e-6 N m", 1e-6),
    ):
        question = Sweep.from_table({"along": along, "range": span, "rate": rate})
        result = run(question, machine, progress=stop_at(1))
        assert result.attrs["rate"] == result.wucht.summary["rate"] == pytest.approx(expected)
        assert result.wucht.summary["rate_chosen"] is False


def test_what_is_not_swept() -> None:
    shaken = load_machine("sperling-vibration/figure-2a")
    assert shaken.shaking is not None
    frequency = shaken.shaking[1].name
    with refused("study.along", "would run away", given=frequency):
        run(Sweep(along=frequency, range=(5.0, 7.0), rate=1e-3), shaken)
    with refused("machine.schedules", given=None):
        run(Sweep(along="impeller.unbalance", range=(1e-3, 2e-3)), load_machine("practice/fan-on-belt"))


def test_an_arrow_leads_from_the_end_of_a_branch_to_where_the_machine_lands(both: xr.Dataset) -> None:
    """In both panels; the band about the speed is its modulation."""
    speed, amplitude = draw(both).axes
    at = both.jump_value.values
    for axis, name, unit in ((speed, "", 1.0), (amplitude, "_amplitude", 1e3)):
        before, after = (unit * both[f"jump_{side}{name}"].values for side in ("from", "to"))
        arrows = [(*arrow.xyann, *arrow.xy) for arrow in axis.texts]
        assert np.array(arrows) == pytest.approx(np.column_stack([at, before, at, after]))
    bands = [collection.get_paths()[0].get_extents().extents for collection in speed.collections]
    for band, way in zip(bands, both.direction.values, strict=True):
        ramp = both.sel(direction=way)
        box = ramp.value.min(), ramp.min_speed.min(), ramp.value.max(), ramp.max_speed.max()
        assert band == pytest.approx([float(x) for x in box])


@pytest.mark.usefixtures("unpainted")
def test_ctrl_c_leaves_a_valid_sweep_that_is_resumed(wucht: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    quick = ("--set", "study.range=[9.0, 10.5]", "--set", "study.rate=0.02", "--set", "study.jump_tolerance=1e-3")
    words = ("run", FIGURE_5, *quick, "-o", "out")
    with monkeypatch.context() as patch:
        patch.setattr(Progress, "update", lambda *_: signal.raise_signal(signal.SIGINT))
        done = wucht(*words)
    assert done.code == 130 and "interrupted" in done.err and "Traceback" not in done.err
    assert xr.load_dataset("out/result.partial.nc", engine="h5netcdf").attrs["finished"] == 0
    done = wucht(*words, "--resume", "--json")
    assert done.code == 0 and "interrupted" not in done.err
    (jump,) = done.document["summary"]["jumps"]
    assert (jump["direction"], jump[OMEGA_1]) == ("up", pytest.approx(9.7856, rel=1e-3))
