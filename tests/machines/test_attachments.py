"""What is fastened to the carrier: from a file and in Python, paths and schedules, studies that know it, what is refused."""

import copy

import numpy as np
import pytest
import sympy as sp
from tests.refusals import refused

from witness import moved
from wucht import CoastDown, Response, run
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.errors import InputError
from wucht.files.building import machine_from

CARRIER = {"mass": 3.0, "stiffness": 8e3, "damping": 20.0}
PLANAR = {"directions": "xyr", "mass": 30.0, "inertia": 4.0, "stiffness": 8e3, "rotation_stiffness": 2e3}
ROTOR = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.03}
DAMPER = {"kind": "friction-damper", "name": "left", "angle": 0.0, "force": "40 N"}
STOP = {"kind": "end-stop", "name": "buffer", "angle": "90 deg", "gap": "10 mm", "stiffness": 4e4, "restitution": 0.5}
LAYER = {"kind": "material-layer", "name": "sand", "mass": "10 kg", "share": 0.3}
DRIVE = {"kind": "linear", "slope": 0.05, "no_load_speed": 90.0}


def described(*attached: dict, carrier: dict = CARRIER, **more: object) -> dict:
    return {"carrier": carrier, "bodies": [ROTOR], "drive": DRIVE, "attachments": list(attached), **more}


def test_a_schedule_of_the_material_closes_the_energy_balance() -> None:
    fill = {"parameter": "sand.mass", "points": [[0.0, 1.0], [0.5, 20.0]]}
    rows = moved(described(LAYER | {"damping": 100.0}, carrier=CARRIER | {"gravity": 9.81}, schedules=[fill]))
    given = rows["supplied_work"] - rows["dissipated_work"] + rows["schedule_work"]
    assert given == pytest.approx(rows["stored_energy"] - rows["stored_energy"][0], abs=1e-9)


@pytest.mark.parametrize(("attached", "words"), [(DAMPER, "the dry friction of 'left'"), (STOP, "the end stop 'buffer'")])
def test_what_needs_a_linear_carrier_refuses_the_others(attached: dict, words: str) -> None:
    machine = machine_from(described(attached))
    with refused("machine", words, "averaged equations", code="not-linear"):
        averaged_equations_of(machine)
    with refused("machine", words, "study.kind", "closed form", code="not-linear"):
        run(Response(range=(5.0, 60.0)), machine)


def test_coasting_down_they_stay() -> None:
    """With the linear drive gone, dry friction on the carrier brakes the rotor; its own state is kept."""
    half = {}
    for force in (0.0, 40.0):
        machine = machine_from(described(DAMPER | {"force": force}, carrier=CARRIER | {"damping": 0.0}))
        half[force] = run(CoastDown(until=20.0), machine).wucht.summary["half_time"]
    assert half[0.0] is None
    assert 0 < half[40.0] < 20


@pytest.mark.parametrize(
    ("document", "where", "sentence"),
    [
        (described({"kind": "end-stop"}), "attachments[0].", "this key is missing"),
        (described(DAMPER, DAMPER), "attachments[1].name", "this name is already used"),
        (described(DAMPER | {"at": [0.1, 0.0]}), "attachments[0] (left).at", "allowed only on a carrier that turns"),
        (described(LAYER, carrier={"directions": "fixed"}), "attachments[0]", "does not move in the direction"),
        (described(STOP | {"gap": "-1 mm"}), "attachments[0] (buffer).gap", "at least 0 m"),
        (described(LAYER | {"mass": 0}), "attachments[0] (sand).mass", "greater than 0 kg"),
        (described() | {"attachments": DAMPER}, "attachments", "must be tables: [[machine.attachments]]"),
    ],
)
def test_what_is_refused(document: dict, where: str, sentence: str) -> None:
    with pytest.raises(InputError) as error:
        machine_from(document)
    assert error.value.location.startswith(f"machine.{where}")
    assert sentence in error.value.explanation


def test_bodies_of_a_screen_turn_them_along() -> None:
    """A viscous-like check of the place: a stop at the end of a screen is met by its turning alone."""
    stop = STOP | {"at": ["0.5 m", "0 m"], "gap": "1 mm", "stiffness": 1e6}
    rows = moved(described(stop, carrier=PLANAR) | {"bodies": [ROTOR | {"eccentricity": 0.0}]}, {"carrier": {"vr": 0.5}})
    highest = (rows["carrier.y"] + 0.5 * rows["carrier.r"]).max()
    # The place weighs 1/(1/m + a^2/J) there.
    weight = 1 / (1 / 32.0 + 0.25 / 4.0)
    assert highest == pytest.approx(0.001 + 0.25 * (weight / 1e6) ** 0.5, rel=2e-2)


@pytest.mark.parametrize(("at", "hint"), [(None, True), ([0.5, 0.0], False)])
def test_on_a_carrier_that_only_turns_a_part_needs_a_place_off_its_axis_of_motion(at: object, hint: bool) -> None:
    """Along the line from the pivot to its place nothing moves, and at the pivot neither."""
    rocking = {"directions": "r", "inertia": 4.0, "rotation_stiffness": 2e3}
    place = {} if at is None else {"at": at}
    with refused("machine.attachments[0]", given="left") as error:
        machine_from(described(DAMPER | place, carrier=rocking))
    assert ("at = [x, y]" in error.value.explanation) is hint
    upright = machine_from(described(DAMPER | {"at": [0.5, 0.0], "angle": "-90 deg"}, carrier=rocking))
    assert "left.force" in upright.values


SIEVE = {
    "carrier": {"mass": 30.0, "stiffness": [8e3, 1e4], "damping": [20.0, 30.0]},
    "bodies": [{"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": 0.04, "inertia": 0.05, "bearing_damping": 0.01}],
    "drive": {"kind": "linear", "slope": 0.2, "no_load_speed": 90.0},
}
SAND = {"kind": "material-layer", "name": "sand", "mass": 10.0, "share": 0.3, "damping": 700.0}
SANDY = SIEVE | {"attachments": [SAND]}
HEAVIER = SIEVE | {"carrier": {"mass": 33.0, "stiffness": [8e3, 1e4], "damping": [720.0, 730.0]}}


def test_it_is_a_carrier_with_more_mass_and_damping() -> None:
    """States, works and bearing forces: what a layer does to the carrier is none of them."""
    loaded, heavier = moved(SANDY), moved(HEAVIER)
    assert loaded.keys() == heavier.keys()
    for name, values in heavier.items():
        assert loaded[name] == pytest.approx(values, rel=1e-9, abs=1e-12), name


def test_the_deck_bears_all_of_its_weight() -> None:
    heavy = copy.deepcopy(SANDY)
    heavy["carrier"]["gravity"] = 9.81
    assert moved(heavy, grid=np.array([0.0, 1e-6]))["carrier.y"][0] == pytest.approx(-45.0 * 9.81 / 1e4, rel=1e-12)


def test_on_a_screen_that_turns_it_is_where_it_lies() -> None:
    planar = {"directions": "xyr", "mass": 30.0, "inertia": 4.0, "stiffness": 8e3, "rotation_stiffness": 2e3, "gravity": 9.81}
    machine = machine_from(SIEVE | {"carrier": planar, "attachments": [SAND | {"at": ["-0.3 m", "0.1 m"]}]})
    (_, vx), (_, vy), (chi, turning) = ((c.position, c.velocity) for c in machine.carrier)
    y = machine.carrier[1].position
    layer, numbers = machine.energies[-1], machine.numbers
    square = (vx - 0.1 * turning) ** 2 + (vy - 0.3 * turning) ** 2
    assert sp.expand(layer.kinetic.xreplace(numbers) - 0.3 * 10.0 * square / 2) == 0
    assert sp.expand(layer.dissipation.xreplace(numbers) - 700.0 * square / 2) == 0
    weight = [float(sp.diff(layer.potential.xreplace(numbers), q)) for q in (y, chi)]
    assert weight == pytest.approx([98.1, -0.3 * 98.1], rel=1e-12)
