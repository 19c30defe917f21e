"""The numbers of locking, of motions whose drift, phase and speeds are known, whichever way they go."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from motions import END, W, seen, steady
from test_locking import pair, shaken

from wucht.dynamics.verdicts.locking import (
    _difference_bounds,
    _joint_evidence,
    assess_locking,
    is_locking,
    rotor_phases,
)
from wucht.dynamics.verdicts.outcomes import Evidence
from wucht.files.building import machine_from


def assessed(machine: Any, *angles: Any) -> Any:
    found = assess_locking(machine, seen(machine, END, *angles))
    assert found is not None
    return found


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_phase_creeps_by_what_it_moves_in_the_second_half(way: float) -> None:
    """Of the last half of the run, in which 50 of 101 turns are made."""
    found = assessed(pair(), steady, lambda t: W * t + 1.0 + way * 1e-3 * t)
    assert found.creep == pytest.approx(1e-3 * END / 4, rel=0.05)
    assert found.phases["e"] == pytest.approx(1.0 + way * 1e-3 * (END - 2.5), abs=1e-3)
    assert found.window == pytest.approx((END / 2, END), abs=1.0)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_speed_changes_by_the_difference_of_the_halves(way: float) -> None:
    """Both rotors gain or lose 1e-4 of their speed each second."""

    def turning(t: Any) -> Any:
        return W * (t + way * 0.5e-4 * t**2)

    found = assessed(pair(), turning, lambda t: turning(t) + 0.25)
    assert found.change == pytest.approx(W * 1e-4 * END / 4, rel=0.05)
    assert found.speeds["d"] == pytest.approx(W * (1 + way * 1e-4 * 0.75 * END), rel=1e-3)


@pytest.mark.parametrize(("first", "second"), [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)])
def test_speeds_have_signs_and_phases_are_in_the_senses(first: float, second: float) -> None:
    found = assessed(pair(), lambda t: first * W * t, lambda t: second * (W * t + 0.75))
    assert found.speeds == pytest.approx({"d": first * W, "e": second * W})
    assert found.smooth_speeds == pytest.approx(found.speeds)
    assert found.phases == {"e": pytest.approx(0.75)} and found.creep == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_phase_to_the_vibration(sense: float) -> None:
    """As sigma phi - w t."""
    found = assessed(shaken(), lambda t: sense * (W * t + 0.5))
    assert found.phases == {"vibration": pytest.approx(0.5)} and found.speeds["d"] == pytest.approx(sense * W)
    assert found.evidence.is_locked is True
    time = np.array([0.0, 1.0, 2.0])
    assert rotor_phases(shaken(), time, {"d": sense * (W * time + 0.5)})["vibration"] == pytest.approx([0.5] * 3)
    assert rotor_phases(pair(), time, {"d": sense * W * time, "e": -W * time - 0.25})["e"] == pytest.approx([0.25] * 3)


@pytest.mark.parametrize(
    ("free", "shaking", "judged"), [(1, False, False), (2, False, True), (1, True, True), (0, True, False)]
)
def test_which_machines_are_judged_by_locking(free: int, shaking: bool, judged: bool) -> None:
    rotor = {"kind": "rotor", "mass": 2.0, "unbalance": 1e-3, "inertia": 0.1}
    names = ["a", "b"]
    held = [{"on": n, "kind": "constant-speed", "speed": W} for n in names[free:]]
    driven = [{"on": n, "kind": "linear", "slope": 0.1, "no_load_speed": W} for n in names[:free]]
    motion = {"directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": W}}
    machine = machine_from({
        "carrier": motion if shaking else {"mass": 1.0, "stiffness": 1e3, "damping": 1.0},
        "bodies": [rotor | {"name": n} for n in names], "drives": [*held, *driven],
    })  # fmt: skip
    assert is_locking(machine) is judged


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_difference_that_falls_has_bounds_on_its_side(way: float) -> None:
    means = way * 0.5 * 0.5 ** np.arange(5.0)
    low, high = _difference_bounds(means, 1e-9)
    assert low <= high and low <= way * 0.5 / 16 <= high
    assert abs(low if way < 0 else high) <= 0.5 / 16 + 1e-9 and abs(low) + abs(high) < 0.07, "it falls on"


@pytest.mark.parametrize(("growing", "settles", "expected"), [(False, True, True), (True, True, False), (False, False, False)])
def test_a_rotor_in_the_common_motion(growing: bool, settles: bool, expected: bool) -> None:
    common = Evidence(True, (1.0, 1.0), (1.0, 1.0), has_settled=settles, residual=(0.1, 0.2), modulation=(0.0, 0.0))
    of = Evidence(True, (9.0, 9.0), (9.0, 9.0), residual=(0.3, 0.4), lags=((0.0, 0.5),), modulation=(0.5, 0.6))
    joint = _joint_evidence(SimpleNamespace(evidence=of, growing=growing), common)  # type: ignore[arg-type]
    assert joint.has_settled is expected
    assert (joint.mean_speed, joint.residual, joint.lags) == ((1.0, 1.0), (0.3, 0.4), ((0.0, 0.5),))
    assert joint.modulation == (0.5, 0.6), "its modulation lasts"


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("share", "turns"), [(1.0, 5), (0.0, 5), (0.9, 10), (0.96, 25), (0.99, 5), (1.25, 8), (-0.9, 10)])
def test_the_final_window_is_a_twentieth_of_the_turns_in_whole_beats(share: float, turns: int, way: float) -> None:
    """Of 101 turns; beats of 10, 25 and 4 turns; one of 100 turns is longer than the last half, and none is seen."""
    found = assessed(pair(), lambda t: way * W * t, lambda t: way * share * W * t)
    begin, end = found.final.time[0], found.final.time[-1]
    assert (end - begin) * W / (2 * np.pi) == pytest.approx(turns, abs=0.01)
    assert end == pytest.approx(END, abs=0.1) and found.window[0] == pytest.approx(END / 2, abs=1.0)
    assert found.final_speeds == pytest.approx({"d": way * W, "e": way * share * W}, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("share", [0.93, 1.07, -0.93, -1.07])
def test_final_speeds_are_means_over_whole_beats_which_are_no_whole_turns(share: float, way: float) -> None:
    """Beats of 14.3 turns, in which the second rotor, slower or faster, is up to 0.3 rad ahead of its mean motion or behind."""

    def second(t: Any) -> Any:
        return way * (share * W * t + 0.3 * np.sin(0.07 * W * t))

    found = assessed(pair(), lambda t: way * W * t, second)
    assert found.final_speeds == pytest.approx({"d": way * W, "e": way * share * W}, rel=3e-5)
    turns = (found.final.time[-1] - found.final.time[0]) * W / (2 * np.pi)
    whole = second(found.final.time)[[0, -1]]
    assert abs((whole[1] - whole[0]) / (2 * np.pi * turns) / (way * share) - 1) > 3e-4, "the mean over the window is another"


def test_numbers_at_the_end_are_those_of_the_final_window() -> None:
    """The second rotor loses its speed in the middle of the last half: the mean over that half is not its final speed."""
    late = 0.8 * END
    found = assessed(pair(), steady, lambda t: np.where(t < late, 0.5 * W * t, 0.5 * W * late))
    assert found.final_speeds["e"] == pytest.approx(0.0, abs=1e-6) and abs(found.speeds["e"]) > 0.1 * W
