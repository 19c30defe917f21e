"""The study ``entrainment``: what is changed, refusals, edges by bisection, interruption; the command."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from wucht.errors import InputError
from wucht.machines.catalogue import load_machine
from wucht.machines.files import machine_from
from wucht.machines.machine import Machine
from wucht.machines.vibration import free_speed, sense_of
from wucht.results.store import load, save
from wucht.studies import keeper
from wucht.studies.entrainment import Entrainment, entrainment
from wucht.studies.entrainment.along import along_of, read_along
from wucht.studies.entrainment.branches import Path as Followed
from wucht.studies.entrainment.runs import Band, RunAt, Runs, band_from_start
from wucht.studies.entrainment.slow import Slow

ROTOR = {"kind": "rotor", "mass": 0.1, "eccentricity": 0.01, "inertia": 2e-5}
E1, E2 = ROTOR | {"name": "e1"}, ROTOR | {"name": "e2"}
CARRIER = {"mass": 0.8, "directions": "x", "stiffness": 355.0, "damping": 0.4}
SHAKEN = {"mass": 1.0, "directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": 6.0}}
START = {"e1": {"speed": 12.0}, "e2": {"angle": 0.5, "speed": 12.0}}


def drive(on: str, speed: float = 12.0, **other: Any) -> dict[str, Any]:
    return {"on": on, "kind": "linear", "slope": 3e-5, "no_load_speed": speed} | other


def pair(*speeds: float, **carrier: Any) -> Machine:
    drives = [drive(n, w) for n, w in zip(("e1", "e2"), speeds or (12.0, 12.5), strict=True)]
    return machine_from({"carrier": CARRIER | carrier, "bodies": [E1, E2], "drives": drives})


def bild_2() -> Machine:
    return load_machine("sperling-vibration/figure-2a")


def summary(machine: Machine, **table: Any) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(entrainment(machine, Entrainment.read(table, machine)).attrs["summary"])
    return found


# What is changed


def test_what_is_changed_if_nothing_is_said() -> None:
    assert read_along({}, bild_2()) == "drive.no_load_speed"
    assert read_along({}, pair()) == "detuning"
    assert read_along({}, load_machine("sperling-vibration/sustained-rotation")) == "carrier.motion.amplitude"
    three = machine_from({
        "carrier": CARRIER, "bodies": [E1, E2, ROTOR | {"name": "e3"}], "drives": [drive(n) for n in ("e1", "e2", "e3")],
    })  # fmt: skip
    assert read_along({}, three) == "drives.e1.no_load_speed"


def test_the_detuning_leaves_the_mean_and_the_senses() -> None:
    """Exciters that turn against each other: the second motor is the faster one where the detuning is positive."""
    machine = pair(12.0, -13.0)
    along = along_of(machine, "detuning")
    assert along.own == pytest.approx(1.0)
    assert along.at(machine, along.own).values == pytest.approx(machine.values)
    moved = along.at(machine, 3.0)
    assert [free_speed(moved, r) for r in moved.rotors] == pytest.approx([11.0, -14.0])
    assert [sense_of(moved, r) for r in moved.rotors] == [1.0, -1.0]


# Refusals


REFUSED: list[tuple[Callable[[], Machine], dict[str, Any], str]] = [
    (lambda: load_machine("drozdetskaya-2020/r1"), {}, "machine: nothing can be taken along"),
    (bild_2, {"along": "drive.slop"}, "did you mean 'drive.slope'"),
    (bild_2, {"along": "detuning"}, "study.along: given 'detuning'; allowed for a machine with two rotors"),
    (bild_2, {"along": "drive.slope"}, "study.range: this key is missing; needed is a pair"),
    (bild_2, {"range": [6.0, 5.0]}, "low below high"),
    (bild_2, {"range": ["1 kg", "2 kg"]}, "study.range[0]"),
    (bild_2, {"along": "drive.slope", "range": [-1.0, 1.0]}, "study.range[0]"),
    (bild_2, {"points": 4}, "study.points: given 4; allowed is a whole number from 5"),
    (bild_2, {"points": 7.5}, "study.points"),
    (bild_2, {"points": True}, "study.points"),
    (bild_2, {"resolution": 0}, "study.resolution"),
    (bild_2, {"until": "1 kg"}, "study.until"),
    (bild_2, {"start": {"rotr": 1}}, "study.start"),
    (bild_2, {"start": 3}, "study.start"),
    (bild_2, {"alon": 3}, "did you mean 'along'"),
]


@pytest.mark.parametrize("case", REFUSED, ids=[str(c[1]) + c[2][:8] for c in REFUSED])
def test_bad_input_is_refused(case: tuple[Callable[[], Machine], dict[str, Any], str]) -> None:
    machine, table, says = case[0](), case[1], case[2]
    with pytest.raises(InputError) as refused:
        Entrainment.read(table, machine).check(machine)
    assert says in str(refused.value)


def test_a_drive_that_prescribes_the_speed_is_refused() -> None:
    given = {"on": "e3", "kind": "constant-speed", "speed": 12.0}
    machine = machine_from({
        "carrier": CARRIER, "bodies": [E1, E2, ROTOR | {"name": "e3"}], "drives": [drive("e1"), drive("e2"), given],
    })  # fmt: skip
    with pytest.raises(InputError, match="prescribes the speed of 'e3': it cannot be taken along"):
        Entrainment.read({}, machine)


def test_a_drive_without_no_load_speed_needs_along() -> None:
    motor = {"on": "e1", "kind": "constant-torque", "torque": 1e-4}
    machine = machine_from({"carrier": SHAKEN, "bodies": [E1 | {"bearing_damping": 1e-5}], "drive": motor})
    with pytest.raises(InputError, match=r"study\.along: this key is missing; the main rotor's drive has no no_load"):
        Entrainment.read({}, machine)
    assert Entrainment.read({"along": "drive.torque", "range": [0.0, 1e-3]}, machine).along == "drive.torque"


# The band from the start


def stepped(*bands: tuple[float, float]) -> Callable[[float], RunAt]:
    """A machine that is taken along within some bands."""

    def run(value: float) -> RunAt:
        taken = any(low <= value <= high for low, high in bands)
        return RunAt(value, 1.0, taken, 1.0, (0.0, 1.0), 1.0, np.zeros(2))

    return run


def band(run: Callable[[float], RunAt], own: float, low: float = 0.0, high: float = 10.0, points: int = 11) -> Band | None:
    noted: list[RunAt] = []
    found = band_from_start(run, [run(v) for v in np.linspace(low, high, points)], own, 1e-6, noted.append)
    assert all(low < r.value < high for r in noted)
    return found


def test_both_edges_are_bisected() -> None:
    found = band(stepped((2.3, 7.9)), 5.0)
    assert found is not None
    assert (found.low, found.high) == pytest.approx((2.3, 7.9), abs=1e-6)
    assert found.islands == ()


def test_an_edge_beyond_the_range_is_none() -> None:
    found = band(stepped((-1.0, 7.9)), 5.0)
    assert found is not None
    assert found.low is None
    assert found.high == pytest.approx(7.9, abs=1e-6)


def test_where_nothing_is_taken_along_there_is_no_band() -> None:
    assert band(stepped(), 5.0) is None


def test_the_band_is_that_of_the_machine_else_the_widest() -> None:
    two = stepped((0.5, 2.5), (4.6, 9.4))
    mine, widest = band(two, 1.5), band(two, 3.0)
    assert mine is not None
    assert widest is not None
    assert (mine.low, mine.high) == pytest.approx((0.5, 2.5), abs=1e-6)
    assert (widest.low, widest.high) == pytest.approx((4.6, 9.4), abs=1e-6)
    assert [i for i in mine.islands if i[0] <= 5.0 <= i[1]]


def test_a_gap_beside_an_edge_is_found() -> None:
    """The scan steps over it; the probes around the edge do not."""
    found = band(stepped((2.0, 6.4), (6.6, 6.9)), 5.0)
    assert found is not None
    assert found.high == pytest.approx(6.4, abs=1e-6)
    assert len(found.islands) == 1


# Branches of the slow equations


def test_a_closed_branch_is_walked_once() -> None:
    machine = bild_2()
    slow = Slow(machine, along_of(machine, "drive.no_load_speed"), {"rotor": 1.0}, (-300.0, 300.0))
    path = Followed(slow)
    (branch,) = path.branches(np.array([5.5, 6.0, 7.0]), None)
    assert branch.closed
    turned = branch.states[0]
    assert abs(turned[-1] - turned[0]) == pytest.approx(2 * math.pi, abs=1e-9)
    assert len(path.intervals([branch])) == 1


def test_a_branch_ends_at_the_limits() -> None:
    machine = bild_2()
    slow = Slow(machine, along_of(machine, "drive.no_load_speed"), {"rotor": 1.0}, (5.0, 6.0))
    path = Followed(slow)
    found = path.branches(np.array([5.5]), None)
    assert len(found) == 2
    for branch in found:
        assert not branch.closed
        assert sorted([branch.values[0], branch.values[-1]]) == pytest.approx([5.0, 6.0], abs=1e-12)
    (stretch,) = path.intervals(found)
    assert (stretch.low.kind, stretch.high.kind) == ("range", "range")


def test_a_band_far_from_the_vibration_is_found() -> None:
    """A carrier that takes much power at the frequency: the motor must be set far beyond it, 2 (power)/(frequency) further."""
    carrier = {
        "mass": 1.0, "directions": "xy", "stiffness": [0.0, 400.0], "damping": [0.0, 2.0],
        "motion": {"direction": "x", "amplitude": 1e-3, "frequency": 6 * math.pi},
    }  # fmt: skip
    machine = machine_from({"carrier": carrier, "bodies": [ROTOR | {"name": "r"}], "drive": drive("r", 19.0)})
    slow = Slow(machine, along_of(machine, "drive.no_load_speed"), {"r": 1.0}, (-900.0, 900.0))
    path, w = Followed(slow), 6 * math.pi
    (branch,) = path.branches(np.array([19.0, w]), None)
    (stretch,) = path.intervals([branch])
    y = w**2 * 1e-3 / (400 - 1.1 * w**2 + 2j * w)  # the carrier's motion across; its damper brakes, the one along x turns
    brake, torque = 2 * w * abs(y) ** 2 / 2, 1e-3 * w**2 * 1e-3 / 2
    assert (stretch.low.value, stretch.high.value) == pytest.approx(
        (w + (brake - torque) / 3e-5, w + (brake + torque) / 3e-5), rel=1e-8
    )


def test_an_undriven_rotor_is_sustained_in_either_sense() -> None:
    machine = load_machine("sperling-vibration/sustained-rotation")
    along, found = along_of(machine, "carrier.motion.amplitude"), []
    for sense in (1.0, -1.0):
        slow = Slow(machine, along, {"rotor": sense}, (0.0, 0.1))
        found.append(slow.rates(np.array([[0.3], [5.0]]), 0.005)[0])
    assert np.array_equal(*found)
    assert found[0].any()


# The study


def test_the_summary_has_the_keys_of_the_contract() -> None:
    s = summary(bild_2(), points=5, resolution=0.1)
    assert {"existence_band", "band_from_rest", "phase", "mean_speed", "window"} <= s.keys()
    assert s["range"][0] < s["existence_band"][0] < s["existence_band"][1] < s["range"][1]


def test_a_long_run_up_is_waited_for() -> None:
    """A heavy rotor needs 200 s to reach the frequency: after the first look, at 210 s, it would not count as taken along."""
    heavy = bild_2().with_values({"rotor.inertia": 1e-3, "carrier.motion.amplitude": 4e-3, "drive.no_load_speed": 6.6})
    s = summary(heavy, points=5, range=[6.5, 6.7], resolution=0.1)
    assert s["outcome"] == "entrained"


def test_without_slow_equations_the_full_ones_answer() -> None:
    """A pivot that turns with its rotor leaves none: the range must be given, and a warning says so."""
    hung = {
        "kind": "pendulum", "name": "p", "about": "e1", "mass": 0.01, "length": 0.01, "damping": 1e-4,
        "suspension": [2e-3, 0.0],
    }  # fmt: skip
    machine = machine_from({"carrier": CARRIER, "bodies": [E1, E2, hung], "drives": [drive("e1"), drive("e2", 12.2)]})
    with pytest.raises(
        InputError, match=r"study\.range: this key is missing, and cannot be chosen: the slow equations are left"
    ):
        entrainment(machine, Entrainment.read({"start": START}, machine))
    table = {"start": START, "range": [-1.0, 1.0], "points": 5}
    found = entrainment(machine, Entrainment.read(table, machine))
    s = json.loads(found.attrs["summary"])
    assert s["existence_band"] is None
    assert s["outcome"] == "synchronised"
    assert s["stable"]
    assert "the slow equations are left out: has no slow equations" in found.attrs["warnings"]


def test_bodies_count_as_released() -> None:
    """An exciter that is locked for a second takes part in the synchronous motion."""
    late = E2 | {"release": {"time": 1.0}}
    machine = machine_from({"carrier": CARRIER, "bodies": [E1, late], "drives": [drive("e1"), drive("e2", 12.2)]})
    s = summary(machine, start={"e1": {"speed": 12.0}}, points=5, range=[-1.0, 1.0], resolution=0.1)
    assert s["outcome"] == "synchronised"
    assert s["stable"]
    assert s["phase"] == pytest.approx(s["phase_slow"], abs=1e-3)


def test_a_study_that_is_interrupted_keeps_what_it_has() -> None:
    def stop(done: float, total: float) -> None:
        assert done < total
        if done >= 6:
            raise KeyboardInterrupt

    machine = bild_2()
    found = entrainment(machine, Entrainment.read({"points": 9}, machine), stop)
    assert found.attrs["finished"] == 0
    assert found.sizes["run"] == 4
    s = json.loads(found.attrs["summary"])
    assert s["sentence"].endswith("the study was interrupted before its band was found")
    assert "interrupted after 4 runs from the start; --resume goes on" in found.attrs["warnings"]
    assert s["existence_band"] is not None
    assert s["band_from_rest"] is None


@pytest.mark.parametrize("file", ["sperling-vibration/figure-2a", "sperling-vibration/self-synchronisation-soft-unequal"])
@pytest.mark.parametrize("after", [1, 6])
def test_resumed_it_is_the_uninterrupted_one(file: str, after: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the file, with the runs that were made."""
    machine = load_machine(file)
    question = Entrainment.read({"points": 6, "resolution": 0.2}, machine)

    def stop(done: float, _: float) -> None:
        if done >= after:
            raise KeyboardInterrupt

    broken = entrainment(machine, question, stop)
    assert broken.sizes["run"] == max(1, after - 2)
    save(broken, tmp_path / "result.nc")
    whole, made = entrainment(machine, question), 0

    def count(self: Runs, value: float, until: float) -> RunAt:
        nonlocal made
        made += 1
        return genuine(self, value, until)

    genuine = Runs._made
    monkeypatch.setattr(Runs, "_made", count)
    again = entrainment(machine, question, resume=load(tmp_path / "result.nc"))
    for name in whole.variables:
        assert again[name].equals(whole[name]), name
    assert again.attrs["summary"] == whole.attrs["summary"]
    assert again.attrs["finished"] == 1
    resumed, made = made, 0
    entrainment(machine, question)
    assert made - resumed >= after - 2
    made = 0
    entrainment(machine, question, resume=whole)
    assert made <= 1, "the machine's own run, where it must first be known how long it is to be"


def test_only_the_same_machine_and_start_are_resumed() -> None:
    machine = bild_2()
    found = entrainment(machine, Entrainment.read({"points": 5, "resolution": 0.5}, machine))
    finer = entrainment(machine, Entrainment.read({"points": 5, "resolution": 0.4}, machine), resume=found)
    assert finer.attrs["finished"] == 1
    for other, keys in ((machine.with_values({"rotor.inertia": 1.0}), {}), (machine, {"until": 100.0})):
        with pytest.raises(InputError, match="--resume: the result in the output folder is of another machine, parameter"):
            entrainment(other, Entrainment.read({"points": 5, "resolution": 0.5} | keys, other), resume=found)


def test_it_can_be_stopped_within_a_run() -> None:
    told = 0

    def stop(done: float, total: float) -> None:
        nonlocal told
        told += 1
        if told == 3:  # the first step is done after the machine's own run, of many legs
            assert done == 0
            raise KeyboardInterrupt

    machine = bild_2()
    found = entrainment(machine, Entrainment.read({"until": 3000.0}, machine), stop)
    assert found.attrs["finished"] == 0
    assert json.loads(found.attrs["summary"])["outcome"] == "unidentified"


def test_progress_rises_to_its_end_and_results_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(keeper, "SAVE_EVERY_S", 0.0)
    told, kept = [], []
    machine = bild_2()
    entrainment(
        machine, Entrainment.read({"points": 5, "resolution": 0.5}, machine), lambda d, t: told.append((d, t)), kept.append
    )
    done, total = zip(*told, strict=True)
    assert list(done) == sorted(done)
    assert done[-1] == total[-1]
    assert {"run_value", "phase"} <= set(kept[-1])


def test_a_machine_that_cannot_run_says_so() -> None:
    wild = bild_2().with_values({"rotor.inertia": 1e-300})
    found = entrainment(wild, Entrainment.read({"points": 5}, wild))
    assert found.attrs["failure"]
    assert not found.attrs["finished"]


STUDY = """\
[machine]
use = "sperling-vibration/figure-2a"

[study]
kind = "entrainment"
points = 5
resolution = "0.1 rad/s"
"""


def test_the_command(wucht: Callable[..., Any], here: Path) -> None:
    (here / "study.toml").write_text(STUDY, encoding="utf-8")
    said = wucht("run", "study.toml", "-o", "out")
    assert said.code == 0
    for part in (
        "verdict: ENTRAINED", "existence    4.309264 to 8.257106 rad/s (slow equations, ends: fold)", "from start   4.",
        "phase        rotor: -0.40856 rad (-23.41\u00b0), slow equations -0.40799 rad", "mean speed   6.2832 rad/s (60 rpm)",
        "stability    stable", "threshold    the vibration must be larger than 0.3968 mm",
    ):  # fmt: skip
        assert part in said.out, part
    assert wucht("plot", "out/result.nc").code == 0
    assert (here / "out" / "entrainment.png").stat().st_size > 20_000


def test_amplitudes_below_zero_are_refused() -> None:
    machine = load_machine("sperling-vibration/sustained-rotation")
    with pytest.raises(InputError, match=r"study\.range\[0\]: given -3\.0; allowed is an amplitude from 0 on"):
        Entrainment.read({"along": "carrier.motion.amplitude", "range": [-3, 3]}, machine).check(machine)
