"""End stops: the impact of a free mass in closed form, walls on both sides."""

import math

import numpy as np
import pytest

from witness import energy_gap, moved, moved_by_scipy
from wucht.files.building import machine_from

ROTOR = {"kind": "rotor", "name": "drum", "mass": 1.0, "eccentricity": 0.0, "inertia": 0.03}
STOP = {"kind": "end-stop", "name": "buffer", "angle": 0.0, "gap": 0.01, "stiffness": 4e4}


def free(mass: float, *stops: dict, directions: str = "x") -> dict:
    """A mass that nothing but the stops holds."""
    carrier = {"mass": mass - 1.0, "directions": directions, "stiffness": 1e-9}
    return {"carrier": carrier, "bodies": [ROTOR], "attachments": list(stops)}


@pytest.mark.parametrize(("mass", "speed", "e"), [(4.0, 1.0, 0.5), (4.0, 0.2, 0.5), (50.0, 1.0, 0.3), (4.0, 1.0, 1.0)])
def test_a_mass_leaves_with_the_restitution(mass: float, speed: float, e: float) -> None:
    """It goes in as deep as v sqrt(m/c), out at e v, and a quarter of a vibration in, 1/e of it out, later."""
    quarter = math.pi / 2 * math.sqrt(mass / 4e4)
    contact = 0.01 / speed
    grid = np.array([0.0, contact, contact + quarter, contact + quarter * (1 + 1 / e) + 0.1])
    rows = moved(free(mass, STOP | {"restitution": e}), {"carrier": {"vx": speed}}, grid)
    assert rows["carrier.vx"][-1] == pytest.approx(-e * speed, rel=1e-3)
    assert rows["carrier.x"][2] - 0.01 == pytest.approx(speed * math.sqrt(mass / 4e4), rel=1e-3)
    assert rows["carrier.x"][-1] == pytest.approx(0.01 - e * speed * 0.1, abs=1e-4)
    assert rows["dissipated_work"][-1] == pytest.approx(mass * speed**2 * (1 - e**2) / 2, rel=1e-3, abs=1e-12)
    assert energy_gap(rows) < 1e-9


def test_a_viscous_stop_is_a_spring_and_damper() -> None:
    """After half a damped period the speed is exp(-pi zeta/sqrt(1 - zeta^2)) of what it was."""
    mass, zeta = 4.0, 0.2
    rows = moved(free(mass, STOP | {"damping": 2 * zeta * math.sqrt(4e4 * mass)}), {"carrier": {"vx": 1.0}}, np.array([0, 0.1]))
    assert rows["carrier.vx"][-1] == pytest.approx(-math.exp(-math.pi * zeta / math.sqrt(1 - zeta**2)), rel=1e-9)


def test_walls_on_both_sides_of_where_the_gap_was_measured() -> None:
    """Between walls at 13 and -7 mm along a line at 120 degrees, nothing being lost; across the line nothing happens."""
    stop = STOP | {"angle": "120 deg", "rest": "3 mm", "restitution": 1.0, "sides": "both", "stiffness": 1e7}
    along, across = np.array([-0.5, math.sqrt(3) / 2]), np.array([-math.sqrt(3) / 2, -0.5])
    v = 0.8 * along + 0.1 * across
    grid = np.linspace(0.0, 0.5, 5001)
    rows = moved(free(4.0, stop, directions="xy"), {"carrier": {"vx": v[0], "vy": v[1]}}, grid)
    x = np.array([rows["carrier.x"], rows["carrier.y"]])
    depth = 0.8 * math.sqrt(4.0 / 1e7)
    assert (along @ x).max() == pytest.approx(0.013 + depth, rel=1e-4)
    assert (along @ x).min() == pytest.approx(-0.007 - depth, rel=1e-4)
    assert across @ x == pytest.approx(0.1 * grid, abs=1e-9)
    crossings = np.count_nonzero(np.diff(np.sign(along @ np.array([rows["carrier.vx"], rows["carrier.vy"]]))))
    assert crossings == int((0.5 - 0.013 / 0.8) / (0.02 / 0.8 + math.pi * math.sqrt(4.0 / 1e7))) + 1


def test_one_side_leaves_the_other_free() -> None:
    rows = moved(free(4.0, STOP | {"restitution": 0.5}), {"carrier": {"vx": -1.0}}, np.array([0.0, 1.0]))
    assert rows["carrier.x"][-1] == pytest.approx(-1.0, rel=1e-8)


@pytest.mark.slow
def test_it_runs_as_an_independent_integration_says() -> None:
    """Ten impacts of a driven carrier."""
    carrier = {"mass": 3.0, "directions": "x", "stiffness": 2e3, "damping": 5.0}
    stop = STOP | {"gap": "1 mm", "restitution": 0.6}
    document = {"carrier": carrier, "bodies": [ROTOR | {"eccentricity": 0.01}], "attachments": [stop]}
    document |= {"drive": {"kind": "constant-speed", "speed": 30.0}}
    grid = np.linspace(0.0, 3.0, 301)
    rows, expected = moved(document, grid=grid), moved_by_scipy(machine_from(document), grid=grid, max_step=1e-3)
    assert rows["carrier.x"] == pytest.approx(expected["carrier.x"], rel=1e-5, abs=1e-9)
    assert energy_gap(rows) < 1e-8


def test_a_carrier_comes_to_rest_on_a_stop() -> None:
    """Pressed against it by its spring: the stop bears the force with the stiffness c (1 + e^2)/2."""
    carrier = {"mass": 3.0, "directions": "y", "stiffness": 2e3, "damping": 20.0, "gravity": 9.81}
    stop = STOP | {"angle": "-90 deg", "restitution": 0.5}
    rows = moved({"carrier": carrier, "bodies": [ROTOR], "attachments": [stop]}, grid=np.linspace(0.0, 6.0, 7))
    depth = (4.0 * 9.81 - 2e3 * 0.01) / (2e3 + 4e4 * 1.25 / 2)
    assert rows["carrier.y"][-1] == pytest.approx(-0.01 - depth, rel=1e-6)
    assert rows["carrier.vy"][-1] == pytest.approx(0.0, abs=1e-7)


def test_a_stop_that_is_closed_at_rest_is_doubtful() -> None:
    """Displacements count from where the springs are free of force: 4 kg on 2 kN/m hang 19.6 mm below."""
    carrier = {"mass": 3.0, "directions": "y", "stiffness": 2e3, "gravity": 9.81}

    def warnings(**changes: object) -> tuple[str, ...]:
        stop = STOP | {"angle": "-90 deg", "restitution": 0.5} | changes
        return machine_from({"carrier": carrier, "bodies": [ROTOR], "attachments": [stop]}).warnings

    (closed,) = warnings()
    assert closed.startswith("the end stop 'buffer' is closed by 0.00962 m from the start: the carrier rests at 0.01962 m")
    assert warnings(rest="19.62 mm") == ()
    assert warnings(angle="90 deg") == ()
    assert len(warnings(angle="90 deg", sides="both")) == 1
