"""Rotors that are locked, and what becomes of them at the resonance: of synthetic motions."""

from functools import cache

import numpy as np
import pytest
from motions import ROTOR, W, carrier, judged, linear, machine, steady

CAPTURED = "; captured at the resonance: d, e, at 50 % of the speed without vibration"
SYNCHRONISED = "the rotors turn at the same mean speed"


@cache
def exciters(resonance, *free, inertias=(0.1, 0.1)):
    """Rotors d, e, ..., which their drives turn at given multiples of W, 0: none drives it; their resonance likewise."""
    names = "def"[: len(free)]
    bodies = [ROTOR | {"name": n, "mass": 2.0, "inertia": j} for n, j in zip(names, (*inertias, 0.1), strict=False)]
    drives = [linear(f * W) | {"on": n} for n, f in zip(names, free, strict=True) if f]
    return machine(carrier(resonance * W) | {"directions": "x"}, bodies, drives=drives)


def swinging(share, sense=1, decay=70.0):
    """A turn a second, and a swing that decays slowly: in the last tenth it is that share of the speed, to either side."""
    return lambda t: sense * W * t + share * W * np.exp((100 - t) / decay) * 4 / (2 * np.pi) * np.sin(2 * np.pi * t / 4)


def test_exciters_that_swing_against_each_other_at_the_resonance_are_captured():
    """The swing of each decays too slowly to say what comes of it; the mean of both is steady."""
    verdict = judged(exciters(1.2, 2.0, 2.0), swinging(0.002), swinging(-0.002))
    assert verdict.outcome == "synchronised"
    assert verdict.rotors == {"d": "captured", "e": "captured"}
    assert verdict.sentence == SYNCHRONISED + CAPTURED


def test_three_exciters_too():
    verdict = judged(exciters(1.2, 2.0, 2.0, 2.0), swinging(0.002), swinging(-0.001), swinging(-0.001))
    assert set(verdict.rotors.values()) == {"captured"}
    assert "captured at the resonance: d, e, f, at 50 %" in verdict.sentence


def test_exciters_that_turn_against_each_other_too():
    verdict = judged(exciters(1.2, 2.0, -2.0), swinging(0.002), swinging(0.002, sense=-1))
    assert verdict.rotors == {"d": "captured", "e": "captured"}
    assert verdict.sentence == SYNCHRONISED + CAPTURED


def test_in_the_mean_a_heavy_rotor_counts_more():
    """What they do to each other, equal and opposite, moves the light one more."""
    unequal = exciters(1.2, 2.0, 2.0, inertias=(0.1, 0.3))
    assert judged(unequal, swinging(0.003), swinging(-0.001)).rotors == {"d": "captured", "e": "captured"}
    assert judged(unequal, swinging(0.003), swinging(-0.003)).rotors == {"d": "unidentified", "e": "unidentified"}


def test_what_becomes_of_a_swing_that_they_share_is_not_known():
    verdict = judged(exciters(1.2, 2.0, 2.0), swinging(0.002), swinging(0.002))
    assert verdict.rotors == {"d": "unidentified", "e": "unidentified"}
    assert verdict.sentence == SYNCHRONISED


def test_a_swing_against_each_other_that_lasts_is_a_modulation_of_each():
    verdict = judged(exciters(1.2, 2.0, 2.0), swinging(0.002, decay=1e9), swinging(-0.002, decay=1e9))
    assert verdict.rotors == {"d": "captured-modulated", "e": "captured-modulated"}
    assert verdict.sentence == SYNCHRONISED + CAPTURED


@pytest.mark.parametrize(
    ("resonance", "free"),
    [(0.5, (1.0, 1.0)), (3.0, (1.1, 1.1)), (1.2, (1.5, 0.5)), (0.5, (2.0, 2.0))],
    ids=["beyond it", "below all", "all drives together stop short of it", "far beyond it"],
)
def test_exciters_that_are_not_held_at_the_resonance_are_not_called_captured(resonance, free):
    """Among them one whose drive would reach beyond the resonance, and is braked by that of the other."""
    verdict = judged(exciters(resonance, *free), swinging(0.002), swinging(-0.002))
    assert set(verdict.rotors.values()) == {"passed"}
    assert verdict.sentence == SYNCHRONISED


def test_exciters_in_opposition_do_not_shake_the_carrier_and_are_not_captured():
    verdict = judged(exciters(1.2, 2.0, 2.0), steady, lambda t: W * t + np.pi)
    assert verdict.outcome == "synchronised"
    assert verdict.rotors == {"d": "passed", "e": "passed"}
    assert verdict.evidence.resonance is None
    assert verdict.sentence == SYNCHRONISED
    assert judged(exciters(1.2, 2.0, 2.0), steady, lambda t: W * t + 3.0).rotors == {"d": "captured", "e": "captured"}


def test_exciters_in_opposition_rock_a_carrier_that_can_turn():
    """Beside the carrier's middle they are a couple: captured is what that holds, whatever the force alone would do."""
    bodies = [ROTOR | {"name": n, "mass": 2.0, "position": [x, 0.0]} for n, x in (("d", -0.5), ("e", 0.5))]
    rocking = {
        "directions": "xyr",
        "mass": 6.0,
        "inertia": 2.0,
        "rotation_stiffness": 3.0 * (1.3 * W) ** 2,
        "rotation_damping": 1.0,
    }
    drives = [linear(2 * W), linear(2 * W) | {"on": "e"}]
    both = machine(carrier(0.3 * W) | rocking, bodies, drives=drives)
    opposed, together = (judged(both, steady, lambda t, off=off: W * t + off) for off in (np.pi, 0.0))
    assert opposed.rotors == {"d": "captured", "e": "captured"}
    assert together.rotors == {"d": "passed", "e": "passed"}


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(("resonance", "outcome"), [(1.2, "captured"), (0.7, "passed")])
def test_a_rotor_that_nothing_drives_goes_with_the_other(sense, resonance, outcome):
    """The vibration keeps it turning, one way or the other; a heavy one that turns back is no part of the mean."""
    verdict = judged(exciters(resonance, 2.0, 0.0, inertias=(0.1, 0.3)), steady, lambda t: sense * W * t)
    assert verdict.outcome == "synchronised"
    assert verdict.rotors["d"] == outcome


def test_rotors_that_are_not_locked_are_judged_each_for_itself():
    verdict = judged(exciters(1.2, 2.0, 1.5), steady, lambda t: 1.5 * W * t)
    assert verdict.outcome == "not-synchronised"
    assert verdict.rotors == {"d": "captured", "e": "passed"}
    assert verdict.sentence == "the rotors turn at different mean speeds; captured at the resonance: d"
