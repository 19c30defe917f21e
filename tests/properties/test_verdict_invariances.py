"""A verdict depends on the machine alone: not on units, nor on the order in a file, the sense of turning, or the time scale."""

import math
from functools import cache

import pytest

from wucht import RunUp, run
from wucht.files.building import machine_from

TURN = 2 * math.pi

DRUM = {"kind": "rotor", "name": "drum", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03, "bearing_damping": 1e-4}
P1 = {"kind": "pendulum", "name": "p1", "about": "drum", "mass": 0.125, "length": 0.104, "damping": 0.17}
P2 = P1 | {"name": "p2", "mass": 0.15, "length": 0.09}
WITH_PENDULUMS = {
    "carrier": {"mass": 1.0, "stiffness": [1e5, 7e4], "damping": [200.0, 150.0]},
    "bodies": [DRUM, P1, P2],
    "drives": [{"on": "drum", "kind": "linear", "slope": 0.04, "no_load_speed": 200.0}],
}
WEAK, WEAKER = ({"drives": [WITH_PENDULUMS["drives"][0] | {"slope": slope}]} for slope in (0.01, 1e-3))
DRIVELESS = {"carrier": WITH_PENDULUMS["carrier"], "bodies": [DRUM | {"bearing_damping": 0.02}]}
ROLLER = {"kind": "roller", "about": "d", "track_radius": 0.015, "radius": 0.005, "damping": 2e-7}
WITH_ROLLERS = {
    "carrier": {"mass": 0.9, "stiffness": [3906.25, 15650.0], "damping": 5.0},
    "bodies": [
        {"kind": "rotor", "name": "d", "mass": 0.08, "unbalance": 1e-4, "inertia": 0.01},
        ROLLER | {"name": "a", "mass": 0.012},
        ROLLER | {"name": "b", "mass": 0.008},
    ],
    "drives": [{"on": "d", "kind": "constant-speed", "speed": 300.0}],
}
EXCITER = {"kind": "rotor", "mass": 0.1, "eccentricity": 0.01, "inertia": 2e-5}
ENTRAINED = {
    "carrier": {"mass": 1.0, "directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": 6.0}},
    "bodies": [EXCITER | {"name": "e1"}],
    "drives": [{"on": "e1", "kind": "linear", "slope": 3e-5, "no_load_speed": 6.1}],
}
EXCITERS = {
    "carrier": {"mass": 0.8, "directions": "x", "stiffness": 355.0, "damping": 0.4},
    "bodies": [EXCITER | {"name": "e1"}, EXCITER | {"name": "e2", "mass": 0.11}],
    "drives": [{"on": n, "kind": "linear", "slope": 3e-5, "no_load_speed": w} for n, w in (("e1", 12.0), ("e2", 12.2))],
}
CASES = {  # the machine, where it starts, and until when it runs
    "compensated": (WITH_PENDULUMS, {"p1": {"angle": 0.3}, "p2": {"angle": -0.5}}, None),
    "captured": (WITH_PENDULUMS | WEAKER, {"p1": {"angle": 0.3}, "p2": {"angle": -0.5}}, None),
    "captured-modulated": (WITH_PENDULUMS | WEAK, {"p1": {"angle": 0.3}, "p2": {"angle": -0.5}}, 30.0),
    "balancer-captured": (WITH_ROLLERS, {"a": {"angle": 0.3, "speed": 0.0}, "b": {"angle": -0.3, "speed": 0.0}}, 60.0),
    "stopped": (DRIVELESS, {"drum": {"speed": 30.0}}, None),
    "entrained": (ENTRAINED, {"e1": {"angle": 0.4, "speed": 6.0}}, 300.0),
    "synchronised": (EXCITERS, {"e1": {"angle": 0.0, "speed": 12.0}, "e2": {"angle": 0.5, "speed": 12.0}}, 200.0),
}  # fmt: skip


def each(table, change):
    """The table with ``change(key, number)`` in place of each number, in lists and in tables within it too."""

    def changed(key, value):
        if isinstance(value, dict):
            return each(value, change)
        if isinstance(value, list):
            return [changed(key, v) for v in value]
        return change(key, value) if isinstance(value, float) else value

    return {key: changed(key, value) for key, value in table.items()}


UNITS = {
    "mass": ("g", 1e3), "eccentricity": ("um", 1e6), "unbalance": ("g mm", 1e6), "length": ("mm", 1e3), "radius": ("mm", 1e3),
    "track_radius": ("cm", 1e2), "inertia": ("kg cm^2", 1e4), "bearing_damping": ("mN m s", 1e3), "amplitude": ("mm", 1e3),
    "stiffness": ("N/mm", 1e-3), "slope": ("N m / rpm", TURN / 60), "no_load_speed": ("rpm", 60 / TURN),
    "speed": ("rpm", 60 / TURN), "frequency": ("Hz", 1 / TURN), "angle": ("deg", 360 / TURN), "until": ("ms", 1e3),
}  # fmt: skip
DAMPING = {"carrier": ("kN s/m", 1e-3), "bodies": ("N mm s", 1e3)}
RATES = {"stiffness": 2, "damping": 1, "bearing_damping": 1, "slope": 1, "no_load_speed": 1, "speed": 1, "frequency": 1}
SENSES = ("no_load_speed", "speed", "angle")  # what changes its sign in the mirror image at the x-axis


def in_workshop_units(document, start, until):
    def say(damping):
        units = UNITS | {"damping": damping}
        return lambda key, value: f"{value * units[key][1]!r} {units[key][0]}"

    completed = {
        "carrier": each(document["carrier"], say(DAMPING["carrier"])),
        "bodies": [each(b, say(DAMPING["bodies"])) for b in document["bodies"]],
        "drives": [each(d, say(None)) for d in document.get("drives", [])],
    }
    return completed, each(start, say(None)), until and f"{until * 1e3!r} ms"


def in_another_order(document, start, until):
    """The main rotor is the first one: it stays before other rotors."""
    about = [b for b in document["bodies"] if "about" in b]
    rotors = [b for b in document["bodies"] if "about" not in b]
    drives = document.get("drives", [])[::-1]
    return document | {"bodies": [*about[::-1], *rotors], "drives": drives}, dict(reversed(start.items())), until


def mirrored(document, start, until):
    def turned(key, value):
        return -value if key in SENSES else value

    drives = [each(d, turned) for d in document.get("drives", [])]
    return document | {"drives": drives}, each(start, turned), until


def faster_by(rate, document, start, until):
    def faster(key, value):
        return value * rate ** RATES.get(key, 0)

    completed = {
        "carrier": each(document["carrier"], faster),
        "bodies": [each(b, faster) for b in document["bodies"]],
        "drives": [each(d, faster) for d in document.get("drives", [])],
    }
    return completed, each(start, faster), until and until / rate


def verdict(document, start, until):
    asked = {"start": start} | ({"until": until} if until else {})
    return run(RunUp.from_table(asked), machine_from(document)).wucht.summary


@cache
def as_it_is(case):
    return verdict(*CASES[case])


def assert_same(one, other, sense=1, rate=1.0):
    """Two verdicts agree, the other of a machine that turns so and is faster by a factor ``rate``."""
    assert other["outcome"] == one["outcome"]
    assert other.get("rotor_outcomes") == one.get("rotor_outcomes")
    ends = ("min_speed", "max_speed")[::sense]
    speeds = {"final_speed": "final_speed", "min_speed": ends[0], "max_speed": ends[1]}
    largest = max(abs(one["min_speed"]), abs(one["max_speed"]), 1.0)
    for name, there in speeds.items():
        assert sense * other[there] / rate == pytest.approx(one[name], abs=1e-5 * largest), name
    for name in ("settling_time", "modulation_period"):
        assert other[name] == (None if one[name] is None else pytest.approx(one[name] / rate, rel=1e-4)), name
    for name, power in (("final_amplitude", 0), ("peak_amplitude", 0), ("resonance_speed", 1)):
        expected = None if one[name] is None else pytest.approx(one[name] * rate**power, rel=1e-5, abs=1e-9)
        assert other[name] == expected, name
    if one["final_residual_unbalance"] is not None:
        assert other["final_residual_unbalance"] == pytest.approx(one["final_residual_unbalance"], abs=1e-5)
    if one["outcome"] != "balancer-captured":
        assert_same_angles(one["final_phases"], other["final_phases"], sense)
    assert_same_angles(one.get("rotor_phases", {}), other.get("rotor_phases", {}))
    for name, speed in one.get("mean_speeds", {}).items():
        assert sense * other["mean_speeds"][name] / rate == pytest.approx(speed, rel=1e-6)


def assert_same_angles(one, other, sense=1):
    assert other.keys() == one.keys()
    for name, angle in one.items():
        assert math.remainder(sense * other[name] - angle, TURN) == pytest.approx(0.0, abs=1e-4), name


@pytest.mark.parametrize("case", CASES)
def test_each_machine_ends_as_it_was_made_to(case):
    assert as_it_is(case)["outcome"] == case
    assert case in ("entrained", "synchronised") or as_it_is(case)["settling_time"] > 0


@pytest.mark.parametrize("case", CASES)
def test_the_units_of_the_file_do_not_matter_for_the_verdict(case):
    assert_same(as_it_is(case), verdict(*in_workshop_units(*CASES[case])))


@pytest.mark.parametrize("case", CASES)
def test_the_order_of_bodies_and_drives_does_not_matter_for_the_verdict(case):
    assert_same(as_it_is(case), verdict(*in_another_order(*CASES[case])))


def test_which_of_two_exciters_is_the_first_does_not_matter_for_the_verdict():
    document, start, until = CASES["synchronised"]
    one, other = as_it_is("synchronised"), verdict(document | {"bodies": document["bodies"][::-1]}, start, until)
    assert other["outcome"] == one["outcome"]
    assert other["mean_speeds"] == pytest.approx(one["mean_speeds"], rel=1e-6)
    assert other["rotor_outcomes"] == one["rotor_outcomes"]
    assert math.remainder(other["rotor_phases"]["e1"] + one["rotor_phases"]["e2"], TURN) == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("case", CASES)
def test_the_mirror_image_has_the_mirrored_verdict(case):
    assert_same(as_it_is(case), verdict(*mirrored(*CASES[case])), sense=-1)


def test_the_mirror_image_is_as_close_to_the_end_of_its_branch():
    """A pendulum whose pivot lies beside the axis: its phase decides how much unbalance there is, and that whether the drive
    could hold a higher speed too."""
    found = []
    for sense in (1, -1):
        machine = machine_from({
            "carrier": {"stiffness": 1e5, "damping": 400.0},
            "bodies": [
                {"kind": "rotor", "name": "d", "mass": 9.8, "unbalance": 0.004, "inertia": 0.03},
                {"kind": "pendulum", "name": "p", "about": "d", "mass": 0.1, "length": 0.05, "damping": 0.01,
                 "suspension": [0.0, sense * 0.04]},
            ],
            "drive": {"kind": "linear", "slope": 0.002, "no_load_speed": sense * 246.0},
        })  # fmt: skip
        result = run(RunUp(start={"p": sense * 1.5}), machine)
        summary, warnings = result.wucht.summary, result.wucht.warnings
        found.append((summary["outcome"], any("close to its end" in w for w in warnings)))
        assert sense * summary["final_speed"] == pytest.approx(108.12, abs=0.01)
        assert summary["resonance_speed"] == pytest.approx(107.488, abs=1e-3)
    assert found == [("passed", True)] * 2


@pytest.mark.parametrize("rate", [10.0, 1e-3])
@pytest.mark.parametrize("case", CASES)
def test_the_time_scale_does_not_matter_for_the_verdict(case, rate):
    assert_same(as_it_is(case), verdict(*faster_by(rate, *CASES[case])), rate=rate)
