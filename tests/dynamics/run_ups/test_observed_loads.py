"""Loads of motions that are made by hand: the travel of each mount, the force of each rotor, and turning points in time."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups.observed_loads import LoadObserver, largest_magnitude
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine

AWAY = {"x": 3e-3, "y": -4e-3, "r": 2e-3}


@pytest.fixture(scope="module")
def screen() -> Machine:
    """With mounts at (-0.9 m, -0.2 m) and (0.9 m, -0.2 m), which its weight lets sink."""
    return load_machine("practice/screen")


def observer(machine: Machine, signal: Any = None, begin: float = 0.0) -> LoadObserver:
    motion_observer: Any = SimpleNamespace(machine=machine, begin=lambda: None, update=lambda previous, motion: None)
    return LoadObserver(motion_observer, signal, begin, with_largest=True)


def moved(machine: Machine, share: float, time: np.ndarray, speeds: tuple[float, float] = (0.0, 0.0)) -> Any:
    """The carrier is away from its rest position by this share of ``AWAY`` at the first sample, then there."""
    states = np.zeros((len(machine.state_names), len(time)))
    for label, coordinate, rest in zip(machine.labels, machine.carrier, machine.rest, strict=True):
        states[machine.row(coordinate.position)] = rest
        states[machine.row(coordinate.position), 0] += share * AWAY[label]
    for rotor, speed in zip(machine.rotors, speeds, strict=True):
        states[machine.row(rotor.coordinate.velocity)] = speed
    return SimpleNamespace(time=time, states=states, final_parameter_values=np.array(machine.system.values(machine.values)))


def test_the_travel_of_a_mount_is_its_distance_from_where_it_rests(screen: Machine) -> None:
    """A turn chi moves a mount at (a, b) by (-b chi, a chi). The largest of all parts counts."""
    assert np.abs(screen.rest).max() > 1e-3
    loads = observer(screen)
    seen = loads.begin()
    for k, share in enumerate((0.5, 1.0, 0.25)):
        seen = loads.update(seen, moved(screen, share, np.arange(k, k + 3.0)))
    x, y, chi = AWAY.values()
    assert seen.travels == {
        "mount 1": pytest.approx(np.hypot(x + 0.2 * chi, y - 0.9 * chi)),
        "mount 2": pytest.approx(np.hypot(x + 0.2 * chi, y + 0.9 * chi)),
    }


def test_the_largest_force_of_each_rotor(screen: Machine) -> None:
    """e2 alone turns fast, then e1: with U w^2 each, about, beside the weight of 20 kg."""
    loads = observer(screen)
    seen = loads.begin()
    for k, speeds in enumerate(((0.0, 150.0), (-200.0, 0.0))):
        seen = loads.update(seen, moved(screen, 0.0, np.arange(k, k + 3.0), speeds))
    assert set(seen.bearing_forces) == {"e1", "e2"}
    for name, speed in (("e1", 200.0), ("e2", 150.0)):
        assert seen.bearing_forces[name] == pytest.approx(0.45 * speed**2, rel=0.2)


def test_turning_points_follow_those_of_the_motion_before(screen: Machine) -> None:
    signal: Any = lambda motion: np.array([0.0, 2.0, -1.0])  # noqa: E731
    seen = (late := observer(screen, signal, begin=10.0)).update(late.begin(), moved(screen, 0.0, np.arange(3.0)))
    time, values = seen.points.points_to_end()
    assert (time[0], time[-1], values[0], values[-1]) == (10.0, 12.0, 0.0, -1.0)
    assert len(observer(screen).update(late.begin(), moved(screen, 0.0, np.arange(3.0))).points.time) == 0


@pytest.mark.parametrize("time", [[-1.0, 0.0, 1.0], [-1.0, 0.0, 0.7], [-0.4, 0.0, 2.0]])
@pytest.mark.parametrize("top", [0.25, -0.15])
def test_the_largest_magnitude_is_exact_where_its_square_is_a_parabola(time: list[float], top: float) -> None:
    """5 - (t - top)^2, of two components; evenly spaced or not."""
    at = np.array([-3.0, *time, 4.0])
    square = np.maximum(5.0 - (at - top) ** 2, 0.0)
    components = [np.sqrt(square) * 0.6, -np.sqrt(square) * 0.8]
    assert largest_magnitude(at, components) == pytest.approx(5.0**0.5, rel=1e-12)
    assert largest_magnitude(at, [components[0]]) == pytest.approx(0.6 * 5.0**0.5, rel=1e-12)
