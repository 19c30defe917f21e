"""Speeds, families, maps and selections of synchronous states that are made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.refusals import refused

from wucht.analysis.configurations.averaged_stability import REGIONS, Stability
from wucht.analysis.configurations.closed_form import State
from wucht.dynamics.work import Work
from wucht.studies.synchronous_states import computation, dataset, figure
from wucht.studies.synchronous_states.spec import SynchronousStates


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_range_is_searched_in_the_sense_of_the_drive(sense: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A drive that gives torque in its sense alone, up to 300 rad/s; speeds from 1 to 1000 rad/s can be computed."""
    monkeypatch.setattr(computation, "driven_speeds", lambda machine: ((0.3, 300.0), True))
    monkeypatch.setattr(computation, "sense_of", lambda machine, rotor: sense)
    monkeypatch.setattr(computation, "_limits", lambda machine: (1.0, 1000.0))
    torque = lambda w: sense if 0 < sense * w < 300.0 else 0.0  # noqa: E731
    monkeypatch.setattr(computation, "net_torque", lambda machine, rotor: torque)
    machine: Any = SimpleNamespace(rotor="drum", rotors=["drum"], units=SimpleNamespace(speed="rad/s"))

    def searched(low: float, high: float) -> Any:
        return computation._search_range(machine, (sense * low, sense * high))

    assert computation._search_range(machine, None) == ((0.3, 300.0), True)
    for low, high in ((100.0, 200.0), (200.0, 100.0)):
        assert searched(low, high) == ((100.0, 200.0), False), "the end is that of the question"
    assert searched(0.0, 200.0) == ((0.2, 200.0), False) and searched(0.0, 1000.0) == ((1.0, 1000.0), False)
    for code, low, high in (
        ("other-sense", -100.0, 200.0), ("other-sense", -200.0, -100.0), ("limits", 0.5, 1.0), ("limits", 10.0, 1001.0)
    ):  # fmt: skip
        with refused("study.range", given=[sense * low, sense * high], code=code):
            searched(low, high)
    with refused("study.speed", given=None, code="not-driven"):
        searched(300.0, 900.0)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_given_speed_is_one_that_can_be_computed_in_either_sense(sense: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computation, "_limits", lambda machine: (1.0, 1000.0))
    units, free = SimpleNamespace(speed="rad/s"), SimpleNamespace(poles=lambda low, high: [])
    unheld: Any = SimpleNamespace(units=units)
    for speed, allowed in ((0.9, False), (1.0, True), (1000.0, True), (1001.0, False)):
        asked: Any = SimpleNamespace(speed=sense * speed)
        if allowed:
            computation._check_speed(asked, unheld, free, speed)  # type: ignore[arg-type]
            continue
        with refused("study.speed", given=sense * speed):
            computation._check_speed(asked, unheld, free, speed)  # type: ignore[arg-type]


@pytest.mark.parametrize(("here", "along", "verdict"), [
    (True, [True, True], True), (False, [False, None], False), (True, [None, False], None), (False, [True, True], None),
    (None, [True, True], None),
])  # fmt: skip
def test_a_family_is_stable_where_all_its_members_agree(
    here: bool | None, along: list[bool | None], verdict: bool | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Members at the phases 1 and 2, the state itself at 0."""
    monkeypatch.setattr(computation, "family_members", lambda torques, count: np.array([[1.0, 2.0]]))
    by_phase = dict(zip((0.0, 1.0, 2.0), (here, *along), strict=True))
    full = SimpleNamespace(stability=lambda state: Stability(by_phase[float(state.phases[0])], np.array([-1.0])))
    state = State(10.0, np.zeros(1), dimension=1)
    plan: Any = SimpleNamespace(torques=None)
    assert computation._stability(plan, full, state, Work()).stable is verdict  # type: ignore[arg-type]


def test_a_search_whose_end_is_the_programs_choice_is_not_complete(monkeypatch: pytest.MonkeyPatch) -> None:
    every = SimpleNamespace(states=[], complete=True, evidence="all of them")
    monkeypatch.setattr(computation, "all_states", lambda *given: every)
    for chosen in (True, False):
        plan: Any = SimpleNamespace(torques=None, speeds=(1.0, 2.0), is_limit_chosen=chosen)
        search = computation._search(plan, Work())
        assert search.complete is not chosen and ("program's choice" in search.evidence) is chosen


def test_shares_of_a_map_with_a_stable_state_and_with_none() -> None:
    """Of four cells one kind is stable in two, another in one of these; in two of them none is."""
    stable = np.zeros((len(REGIONS), 2, 2), bool)
    stable[0] = [[1, 1], [0, 0]]
    stable[1, 0, 1] = True
    regions: Any = SimpleNamespace(speed=np.array([1.0, 2.0]), ratio=np.array([0.5, 1.5]), stable=stable, exists=stable)
    by_name = {q.name: q.value for q in dataset._map_quantities(regions, "rad/s")}
    shares = by_name["map"]["stable_share"]
    assert (shares[REGIONS[0]], shares[REGIONS[1]], shares[REGIONS[2]], shares["none"]) == (0.5, 0.25, 0.0, 0.5)
    assert np.array_equal(by_name["map_stable"], stable)


def test_of_too_many_states_unstable_ones_are_left_out_first() -> None:
    verdicts = ["unstable", "stable", "unstable", "undecided", "unstable"]
    for most, chosen in ((5, [0, 1, 2, 3, 4]), (3, [0, 1, 3]), (2, [1, 3]), (1, [1])):
        assert dataset.select_states(verdicts, most) == chosen


def test_the_unit_of_an_unbalance() -> None:
    for length, labels, unit in (
        ("", ("x",), ""),
        ("m", ("x", "y"), "kg m"),
        ("m", ("r",), "kg m^2"),
        ("m", ("x", "y", "r"), "kg m"),
    ):
        machine: Any = SimpleNamespace(units=SimpleNamespace(length=length), labels=labels)
        assert dataset._moment(machine) == unit


@pytest.mark.parametrize(
    ("phase", "text"), [(0.0, "0.00"), (-1e-9, "0.00"), (-90.0, "270.00"), (359.996, "0.00"), (359.99, "359.99")]
)
def test_a_phase_is_written_from_zero_to_below_a_turn(phase: float, text: str) -> None:
    assert dataset._degrees(np.radians(phase)) == text


def test_cells_of_a_map_are_centred_and_need_balancing_bodies_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computation, "_limits", lambda machine: (1.0, 1000.0))
    monkeypatch.setattr(computation, "pattern_count", lambda torques: 1)
    unheld: Any = SimpleNamespace(units=SimpleNamespace(speed="rad/s"))

    def mapped(speed: list[Any], ratio: list[Any], **other: Any) -> Any:
        given = {"coefficients": [1.0], "size": 3, "heads": (0, 0, 0), "has_idle_bodies": lambda speeds: True}
        spec = SynchronousStates.from_table({"kind": "synchronous-states", "axes": {"speed": speed, "ratio": ratio}})
        return computation._map(spec, unheld, SimpleNamespace(**given | other))  # type: ignore[arg-type]

    speeds, ratios = mapped([0, 10, 5], [0, 3, 2])
    assert speeds == pytest.approx([1.0, 3.0, 5.0, 7.0, 9.0]) and ratios == pytest.approx([0.75, 2.25])
    for other in ({"heads": (0, 0, 1)}, {"heads": (1, 2, 1)}, {"coefficients": None}, {"size": 2}):
        with refused("study.axes", given=None, code="no-bodies"):
            mapped([0, 10, 5], [0, 3, 2], **other)
    with refused("study.axes", given=None, code="own-torques"):
        mapped([0, 10, 5], [0, 3, 2], has_idle_bodies=lambda speeds: False)
    with refused("study.axes.speed", "1e+03 rad/s", given=[0.0, 1001.0, 5]):
        mapped([0, 1001, 5], [0, 3, 2])


@pytest.mark.parametrize("full", [True, False])
def test_multipliers_are_computed_of_a_limited_number_of_states(full: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computation, "MOST_FULL", 2)
    monkeypatch.setattr(computation, "_search", lambda plan, work: SimpleNamespace(states=["a", "b", "c"]))
    monkeypatch.setattr(computation, "AveragedStability", lambda *given: None)
    described = SimpleNamespace(describe=lambda state, stability: (state, stability.reason))
    monkeypatch.setattr(computation, "ConfigurationDescriber", lambda stability: described)
    computed: list[Any] = []
    monkeypatch.setattr(computation, "_full_configurations", lambda plan, states, work: computed.append(states) or [])
    plan: Any = SimpleNamespace(torques=None, averaged_equations=None, spec=SimpleNamespace(full=full), map=None)
    first, *_ = computation.run(plan, Work())
    reasons = [reason for _, reason in first.configurations]  # type: ignore[misc]
    none, later, never = "the multipliers were not requested", "not computed yet", "states at most"
    expected = [later, later, never] if full else [none] * 3
    assert all(words in reason for words, reason in zip(expected, reasons, strict=True))
    assert [len(states) for states in computed] == ([2] if full else [])


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_speeds_of_the_question_have_the_sense_of_the_rotor(sense: float, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("_state_quantities", "_body_quantities", "_map_quantities", "natural_vibrations", "_warnings"):
        monkeypatch.setattr(dataset, name, lambda *given: [])
    machine = SimpleNamespace(units=SimpleNamespace(speed="rad/s"))
    search = SimpleNamespace(complete=True, evidence="")
    findings: Any = SimpleNamespace(search=search, configurations=[], map=None)
    for fixed, limits in ((100.0, None), (None, (50.0, 200.0))):
        torques = SimpleNamespace(senses=np.array([sense, 1.0]), fixed_speed=fixed, machine=machine, is_coaxial=True)
        plan: Any = SimpleNamespace(torques=torques, machine=machine, speeds=limits, spec=SimpleNamespace(full=False))
        s = dataset.dataset(plan, findings).wucht.summary
        assert s["speed"] == (None if fixed is None else sense * 100.0)
        assert s["range"] == (None if limits is None else [sense * 50.0, sense * 200.0])


@pytest.mark.parametrize(("slow", "full", "warned"), [
    (True, False, True), (False, True, True), (True, True, False),
    (True, None, False), (None, True, False), (None, None, False),
])  # fmt: skip
def test_equations_disagree_where_both_decide(slow: bool | None, full: bool | None, warned: bool) -> None:
    state: Any = SimpleNamespace(
        slow=SimpleNamespace(stable=slow), full=SimpleNamespace(stable=full), phases={"p": np.pi}, name="opposed", reason="why"
    )
    plan: Any = SimpleNamespace(machine=SimpleNamespace(bodies=[], tracks=[]), map=None)
    findings: Any = SimpleNamespace(search=SimpleNamespace(complete=True), map=None)
    warnings = dataset._warnings(plan, findings, [state])
    assert warnings == ["opposed at phases 180 degrees: averaged and full equations disagree; why"] * warned


def test_growth_in_either_equations_is_that_of_the_leading_exponent() -> None:
    slow, full = SimpleNamespace(stable=True, leading=-1.0 + 2.0j), SimpleNamespace(stable=False, leading=0.5 - 3.0j)
    names = (
        "name",
        "type",
        "speed",
        "phases",
        "residual",
        "share",
        "amplitude",
        "stable_share",
        "verdict",
        "overlapping",
        "reason",
    )
    state = SimpleNamespace(dimension=0, multiplicity=1, is_indifferent=False)
    one: Any = SimpleNamespace(**dict.fromkeys(names), slow=slow, full=full, state=state, throw=None)
    entry = dataset._state_entry(one)
    assert (entry["growth_slow"], entry["growth_full"]) == (-1.0, 0.5)
    assert (entry["stable_slow"], entry["stable_full"]) == (True, False)


def test_of_overlapping_states_those_are_told_that_would_be_stable() -> None:
    def state(name: str, verdict: str, overlapping: bool) -> Any:
        return SimpleNamespace(name=name, verdict=verdict, overlapping=overlapping)

    plan: Any = SimpleNamespace(spec=SimpleNamespace(full=True))
    apart, stable, unstable = state("", "stable", False), state("", "stable", True), state("", "unstable", True)
    place = "could bodies overlap: a run-up shows where contacts move them"
    assert dataset._sentence(plan, [apart, stable]).endswith(f"stable: without a name; without a name would be, {place}")
    assert "overlap" not in dataset._sentence(plan, [apart, unstable])


def test_an_axis_of_a_map_has_a_width() -> None:
    for low, high, code in ((10.0, 10.0, "not-increasing"), (20.0, 10.0, "not-increasing"), (-1.0, 10.0, "negative")):
        axes = {"speed": [low, high, 5], "ratio": [0, 3, 2]}
        with refused("study.axes.speed", given=[low, high, 5], code=code):
            SynchronousStates.from_table({"kind": "synchronous-states", "axes": axes})


def test_natural_frequencies_within_the_map_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("name_speeds", "legend_beside"):
        monkeypatch.setattr(figure, name, lambda *given: None)
    monkeypatch.setattr(figure, "_machine_point", lambda axis, result: [])
    result = xr.Dataset(
        {"map_stable": (("region", "map_ratio", "map_speed"), np.zeros((1, 2, 2), int)),
         "natural_frequency": ("mode", [9.0, -15.0, 15.0, 20.0, 21.0])},
        {"region": ["opposed"], "map_speed": [10.0, 20.0], "map_ratio": [0.5, 1.5]},
    )  # fmt: skip
    axis = Figure().add_subplot()
    figure._draw_map(axis, result)
    assert [np.asarray(line.get_xdata())[0] for line in axis.get_lines()] == [15.0, 20.0]
