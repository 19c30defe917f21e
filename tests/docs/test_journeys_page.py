"""The page of user journeys: its commands print what it says, and what one study says agrees with another, or with a pencil."""

from __future__ import annotations

import cmath
import contextlib
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from page_blocks import PAGES, blocks, missing

pytestmark = pytest.mark.slow  # all commands and blocks of the page are run
PAGE = PAGES["docs/journeys.md"]
# Commands that warn: a search as short as this one, a load beyond what the bodies can balance, a motor that does not start.
WARNED = ("study.damping_curve=false", "overloaded", "short.toml", "long.toml", "dips")
VOLTAGE, PAIRS, MAINS = 230.0, 2, 100 * math.pi  # of the motors in both files


@dataclass(frozen=True)
class Journey:
    """A folder in which all commands of a section were run."""

    folder: Path

    def summary(self, place: str) -> dict[str, Any]:
        """The summary of the result in a subfolder."""
        summary: dict[str, Any] = json.loads((self.folder / place / "summary.json").read_text(encoding="utf-8"))["summary"]
        return summary


@pytest.fixture(scope="module")
def journey(wucht_of_module: Any, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Journey]:
    """``journey(section)``: all its commands in the order of the page, in a folder of their own, with what they print."""
    journeys: dict[str, Journey] = {}

    def walk(section: str) -> Journey:
        if section not in journeys:
            folder = tmp_path_factory.mktemp("journey")
            with contextlib.chdir(folder):
                _walk(section, wucht_of_module)
            journeys[section] = Journey(folder)
        return journeys[section]

    return walk


@contextlib.contextmanager
def without_figures() -> Iterator[None]:
    """A blank page is written instead of a figure, as in ``no_figures``: ``wucht plot`` draws one."""
    from matplotlib.figure import Figure

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("wucht.studies.runner.draw", lambda _result, _page=None: Figure((1, 1)))
        yield


def _walk(section: str, wucht: Any) -> None:
    for block in blocks(PAGE, section):
        if block.title:
            Path(block.title).write_text(block.text, encoding="utf-8")
        printed = ""
        for words in block.commands if block.language == "sh" else []:
            with contextlib.nullcontext() if words[1] == "plot" else without_figures():
                done = wucht(*words[1:])
            assert done.code == 0, (words, done.err)
            assert "warning: " not in done.err or words[-1] in WARNED, done.err
            printed += done.out
        assert missing(block.said, printed) == [], printed


@pytest.fixture
def screen(journey: Callable[[str], Journey]) -> Journey:
    return journey("A vibratory screen, and the loss of one of its motors")


@pytest.fixture
def drum(journey: Callable[[str], Journey]) -> Journey:
    return journey("A drum whose balancer is to be sized")


@pytest.fixture
def crusher(journey: Callable[[str], Journey]) -> Journey:
    return journey("A dip of the mains")


def angle(degrees: float) -> float:
    """An angle in (-180, 180]."""
    return math.remainder(degrees, 360.0)


def test_of_two_screens_one_has_an_operating_state(screen: Journey) -> None:
    variants = screen.summary("choice")["variants"]
    speeds = [v["summary"]["operating_speed"] for v in variants]
    assert speeds == [pytest.approx(155.2, abs=0.01), None]


def test_the_operating_state_of_the_screen_is_one_in_four_studies(screen: Journey) -> None:
    """The averaged equations agree with the full ones to 0.2 % in the speed, 2 degrees in the phase and 1 % in the stroke
    (docs/outcomes.md, "Several rotors")."""
    run, failure = screen.summary("results/gravel"), screen.summary("results/gravel/drive-failure")["operation"][0]
    (point,) = [p for p in screen.summary("results/gravel/torque-balance")["working_points"] if p["stable"]]
    (response,) = screen.summary("results/gravel/response")["operation"]
    for speed in (point["speed"], response["speed"], failure["speed"]):
        assert speed == pytest.approx(run["final_speed"], rel=2e-3)
    for phase in (point["phases"]["e2"], failure["phases"]["e2"]):
        assert angle(math.degrees(phase - run["rotor_phases"]["e2"])) == pytest.approx(0.0, abs=2.0)
    for stroke in (response["stroke"], failure["throw"]):
        assert stroke == pytest.approx(run["stroke"], rel=1e-2)
    assert failure["torques"]["e1"] == pytest.approx(point["torque"], rel=1e-2)


def test_the_torque_of_the_motor_is_that_of_its_circuit(screen: Journey) -> None:
    """T = 3 U^2 (R_2/s)/(w_s ((R_1 + R_2/s)^2 + (X_1 + X_2)^2)) at the slip of the working point."""
    (point,) = [p for p in screen.summary("results/gravel/torque-balance")["working_points"] if p["stable"]]
    synchronous = MAINS / PAIRS
    rotor = 6.4 / (1 - point["speed"] / synchronous)
    torque = 3 * VOLTAGE**2 * rotor / (synchronous * ((7.5 + rotor) ** 2 + 16.0**2))
    assert point["torque"] == pytest.approx(torque, rel=1e-6)


def test_the_bearings_of_the_screen_by_hand(screen: Journey) -> None:
    """The carrier moves along a line against the unbalance: the mean force is U w^2 - m a/2, of a rotor of mass m on a carrier
    with acceleration amplitude a. The mean of the magnitude differs from that by the square of m a/(U w^2), below half a
    per cent; the cubic mean of a force that varies by a tenth is above the mean by as little."""
    run = screen.summary("results/gravel")
    speed = run["final_speed"]
    force = 0.38 * speed**2 - 20.0 * run["stroke"] / 2 * speed**2 / 2
    assert run["steady_bearing_forces"]["e1"] == pytest.approx(force, rel=5e-3)
    load = run["equivalent_bearing_loads"]["e1"]
    assert load == pytest.approx(force / 2, rel=1e-2)
    hours = (45e3 / load) ** (10 / 3) * 1e6 / (60 * speed * 30 / math.pi)
    assert run["bearing_life"]["e1"] == pytest.approx(hours, rel=1e-4)
    assert hours > 20e3


def test_the_loss_of_a_motor_is_that_of_a_run_without_its_voltage(screen: Journey) -> None:
    """Both have settled: to 0.1 %, and half a degree. The run-up begins at rest and loses the motor at another angle."""
    (case,) = [c for c in screen.summary("results/gravel/drive-failure")["cases"] if c["drive"] == "e1"]
    run = screen.summary("results/lost")
    assert case["outcome"] == run["outcome"] == "synchronised"
    assert abs(run["final_speed"]) == pytest.approx(case["speed"], rel=1e-3)
    assert run["stroke"] == pytest.approx(case["throw"], rel=1e-3)
    assert math.degrees(run["throw_direction"] - case["throw_direction"]) == pytest.approx(0.0, abs=0.5)
    assert angle(math.degrees(run["rotor_phases"]["e2"] - case["phases"]["e2"])) == pytest.approx(0.0, abs=1.0)


def test_the_other_motor_covers_the_losses_of_both(screen: Journey) -> None:
    """0.01 N m s in the bearings of each rotor; the rest, a tenth at most, is what the vibration costs in the mounts."""
    for case in screen.summary("results/gravel/drive-failure")["cases"]:
        left = "e2" if case["drive"] == "e1" else "e1"
        bearings = 2 * 0.01 * case["speed"]
        assert case["torques"][case["drive"]] == 0.0
        assert bearings < abs(case["torques"][left]) < 1.15 * bearings


def test_the_recommendation_is_what_the_file_has(drum: Journey) -> None:
    recommended = drum.summary("results/drum")["recommended"]["parameters"]
    assert [recommended["mass"], recommended["damping"]] == pytest.approx([0.078, 0.027], rel=1e-2)


def test_the_balancer_is_lighter_and_does_what_it_says(drum: Journey) -> None:
    """A run settles in the median time of those of the search, to a tenth, which is the scatter over the starts; and the peak
    is that of a body lighter by two fifths, well below the one before."""
    before, after = drum.summary("results/drum/run-up"), drum.summary("results/balanced")
    recommended = drum.summary("results/drum")["recommended"]
    assert before["outcome"] == after["outcome"] == "compensated"
    assert after["settling_time"] == pytest.approx(recommended["settling_time"], rel=0.1)
    assert after["settling_time"] < before["settling_time"]
    assert after["peak_amplitude"] < 0.7 * before["peak_amplitude"]


def test_what_two_bodies_can_balance_by_hand(drum: Journey) -> None:
    """2 m l = 16.2 g m: every start with less is compensated, none with more; of 20 g m the difference is left, of vectors,
    since the bodies do not lie exactly opposite to the unbalance: within 2 %."""
    capacity = 2 * 0.078 * 0.104
    curve = drum.summary("results/loads")
    values = [0.005, 0.01, 0.015, 0.02]
    assert [p["estimate"] for p in curve["probability"]] == [float(u < capacity) for u in values]
    overloaded = drum.summary("overloaded")
    assert overloaded["outcome"] == "passed"
    places = [cmath.exp(1j * phase) for phase in overloaded["final_phases"].values()]
    assert overloaded["final_residual_unbalance"] == pytest.approx(abs(1 + capacity / 2 * sum(places) / 0.02), rel=1e-3)
    assert overloaded["final_residual_unbalance"] == pytest.approx(1 - capacity / 0.02, rel=2e-2)


def test_the_figure_and_the_numbers_are_files(drum: Journey) -> None:
    assert (drum.folder / "figures" / "capture-probability.pdf").stat().st_size > 5000
    assert list((drum.folder / "figures").glob("*.csv"))


def test_dips_on_both_sides_of_the_critical_duration(crusher: Journey) -> None:
    """Of 0.93 and 0.95 s, 1 % away, which is the tolerance of the study. The schedules begin at the operating speed with the
    carrier at rest, two seconds before the dip: ten decays of its
    vibration, after which the state is that of the study."""
    study, short, long = (crusher.summary(f"results/{name}") for name in ("crusher", "short", "long"))
    assert 0.93 <= study["critical_duration"] < study["beyond"]["duration"] <= 0.95
    assert study["beyond"]["outcome"] == long["outcome"] == "stopped"
    assert short["outcome"] == study["operating_outcome"] == "passed"
    assert short["final_speed"] == pytest.approx(study["operating_speed"], rel=2e-4)
    assert short["final_amplitude"] == pytest.approx(study["operating_amplitude"], rel=1e-3)
    assert long["peak_amplitude"] == pytest.approx(study["beyond"]["peak_amplitude"], rel=1e-2)


def test_a_dip_of_all_the_voltage_by_hand(crusher: Journey) -> None:
    """Without a motor the load of 40 N m and the bearings, 0.002 N m s, brake 0.3 kg m2 evenly from the operating speed to the
    critical one; the vibration of the resonance between them costs less than 1 % of that."""
    study = crusher.summary("blackout")
    before, after = study["operating_speed"], study["critical_speed"]
    time = 0.3 * (before - after) / (40.0 + 0.002 * (before + after) / 2)
    assert study["critical_duration"] == pytest.approx(time, rel=1e-2)
    assert study["critical_duration"] < crusher.summary("results/crusher")["critical_duration"]
