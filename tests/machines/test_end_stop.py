"""End stops: the impact of a free mass in closed form, walls on both sides."""

import math

import numpy as np
import pytest

from witness import energy_gap, moved
from wucht.files.building import machine_from

ROTOR = {"kind": "rotor", "name": "drum", "mass": 1.0, "eccentricity": 0.0, "inertia": 0.03}
STOP = {"kind": "end-stop", "name": "buffer", "angle": 0.0, "gap": 0.01, "stiffness": 4e4}


def free(mass: float, *stops: dict, directions: str = "x") -> dict:
    """A mass that nothing but the stops holds."""
    carrier = {"mass": mass - 1.0, "directions": directions, "stiffness": 1e-9}
    return {"carrier": carrier, "bodies": [ROTOR], "attachments": list(stops)}


@pytest.mark.parametrize(("mass", "speed", "e"), [(4.0, 1.0, 0.5), (50.0, 1.0, 0.3), (4.0, 1.0, 1.0)])
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
