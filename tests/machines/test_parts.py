"""Parts: their energies are those of the bodies they stand for, and values that no body can have are refused."""

import copy

import pytest
import sympy as sp
from tests.refusals import refused

from wucht.files.building import machine_from

MACHINE = {
    "carrier": {"mass": 1.0, "stiffness": [4e3, 9e3], "damping": [3.0, 5.0], "gravity": 9.81},
    "bodies": [
        {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.1, "inertia": 0.5, "bearing_damping": 0.01},
        {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.5, "length": 0.2, "inertia": 0.03, "damping": 0.02},
        {"kind": "roller", "name": "r", "about": "drum", "mass": 0.25, "track_radius": 0.3, "radius": 0.1, "damping": 0.03},
    ],
    "drive": {"kind": "linear", "slope": 0.05, "no_load_speed": 250.0},
}


def changed(path, value, base=MACHINE):
    """A copy with one key set (or, with None, removed): ``bodies.1.mass``."""
    document = copy.deepcopy(base)
    target = document
    *way, last = (int(key) if key.isdigit() else key for key in path.split("."))
    for key in way:
        target = target[key]
    if value is None:
        del target[last]
    else:
        target[last] = value
    return document


@pytest.fixture(scope="module")
def machine():
    return machine_from(MACHINE)


def symbol(name):
    return sp.Symbol(name, real=True)


def energies_of(machine, index):
    return machine.energies[index]


def moving_point(machine, body, radius):
    """Position and velocity of a point at a distance from the axis, in the body's direction."""
    x, y = (c.position for c in machine.carrier)
    vx, vy = (c.velocity for c in machine.carrier)
    angle, speed = symbol(f"{body}.angle"), symbol(f"{body}.speed")
    position = sp.Matrix([x + radius * sp.cos(angle), y + radius * sp.sin(angle)])
    velocity = sp.Matrix([vx - radius * speed * sp.sin(angle), vy + radius * speed * sp.cos(angle)])
    return position, velocity, speed


def same(first, second):
    return sp.simplify(sp.expand(first - second)) == 0


def test_rotor(machine):
    """A rigid body: its mass moves with its centre and turns with the inertia about it, J - m e^2."""
    m, e, j, b = (symbol(f"drum.{n}") for n in ("mass", "eccentricity", "inertia", "bearing_damping"))
    position, velocity, w = moving_point(machine, "drum", e)
    energies = energies_of(machine, 1)
    assert same(energies.kinetic, m * velocity.dot(velocity) / 2 + (j - m * e**2) * w**2 / 2)
    assert same(energies.potential, m * symbol("carrier.gravity") * position[1])
    assert same(energies.dissipation, b * w**2 / 2)


def test_pendulum(machine):
    m, l, j, b = (symbol(f"p.{n}") for n in ("mass", "length", "inertia", "damping"))  # noqa: E741
    position, velocity, w = moving_point(machine, "p", l)
    energies = energies_of(machine, 2)
    assert same(energies.kinetic, m * velocity.dot(velocity) / 2 + (j - m * l**2) * w**2 / 2)
    assert same(energies.potential, m * symbol("carrier.gravity") * position[1])
    assert same(energies.dissipation, b * (w - symbol("drum.speed")) ** 2 / 2)


def test_a_pendulum_without_inertia_is_a_point():
    point_ball = machine_from(changed("bodies.1.inertia", None))
    m, l = symbol("p.mass"), symbol("p.length")  # noqa: E741
    _, velocity, _ = moving_point(point_ball, "p", l)
    assert same(energies_of(point_ball, 2).kinetic, m * velocity.dot(velocity) / 2)


def test_roller(machine):
    """Without slip the surfaces move alike: R phi_0' = eps phi' + r spin, 000 (3)-(5)."""
    m, track, r, mu, beta = (symbol(f"r.{n}") for n in ("mass", "track_radius", "radius", "shape_factor", "damping"))
    eps = track - r
    _, velocity, w = moving_point(machine, "r", eps)
    w0 = symbol("drum.speed")
    spin = (track * w0 - eps * w) / r
    energies = energies_of(machine, 3)
    assert same(energies.kinetic, m * velocity.dot(velocity) / 2 + mu * m * r**2 * spin**2 / 2)
    assert same(energies.dissipation, beta * (w - w0) ** 2 / 2)


def test_carrier(machine):
    x, y = (c.position for c in machine.carrier)
    vx, vy = (c.velocity for c in machine.carrier)
    energies, at = energies_of(machine, 0), machine.numbers
    assert same(energies.kinetic.xreplace(at), 0.5 * (vx**2 + vy**2))
    assert same(energies.potential.xreplace(at), 2e3 * x**2 + 4.5e3 * y**2 + 9.81 * y)
    assert same(energies.dissipation.xreplace(at), 1.5 * vx**2 + 2.5 * vy**2)


def test_linear_drive(machine):
    (applied,) = energies_of(machine, 4).applied_forces
    assert applied.energy_side == "supplied"
    assert same(applied.power.xreplace(machine.numbers), 0.05 * (250 - symbol("drum.speed")) * symbol("drum.speed"))


def test_a_constant_speed_is_prescribed():
    drive = {"kind": "constant-speed", "speed": "600 rpm", "angle": "90 deg"}
    machine = machine_from(changed("drive", drive))
    assert machine.rotor.coordinate.prescribed_velocity == symbol("drive.speed")
    assert machine.values["drive.speed"] == pytest.approx(20 * sp.pi.evalf())
    assert machine.start_angles == {"drum": pytest.approx(float(sp.pi / 2))}
    assert "drum.speed" not in machine.system.state_names


def test_parameters_are_addressed_by_path(machine):
    assert machine.values["drum.eccentricity"] == 0.1
    assert machine.values["carrier.stiffness.y"] == 9e3
    assert machine.values["drive.slope"] == 0.05
    assert machine.parameters["p.damping"].unit == "N m s"
    assert set(machine.values) == set(machine.system.parameter_names)


def test_the_outputs_and_quadratures_of_a_machine(machine):
    assert [o.name for o in machine.system.outputs] == [
        "stored_energy", "motor_torque", "drive_torque", "motor_power", "bearing_force_x", "bearing_force_y",
        "orbit.x", "orbit.vx", "orbit.y", "orbit.vy",
    ]  # fmt: skip
    assert [q.name for q in machine.system.quadratures] == ["supplied_work", "dissipated_work"]
    assert {s.name for s in machine.system.angles} == {"drum.angle", "p.angle", "r.angle"}


def test_unbalances_of_all_kinds(machine):
    bodies = [p for p in machine.parts if hasattr(p, "moment")]
    assert [b.number(b.moment()) for b in bodies] == pytest.approx([0.2, 0.1, 0.05])
    direct = machine_from(changed("bodies.0", {"kind": "rotor", "name": "drum", "mass": 2.0, "unbalance": 0.2, "inertia": 0.5}))
    assert direct.parts[1].number(direct.parts[1].moment()) == 0.2


@pytest.mark.parametrize(
    ("path", "value", "refusal"),
    [
        ("bodies.0.inertia", 0.0199, refused("machine.bodies[0] (drum).inertia", "2 = 0.02", given=0.0199)),
        ("bodies.1.inertia", 0.0199, refused("machine.bodies[1] (p).inertia", "l", "2 = 0.02", given=0.0199)),
        ("bodies.2.radius", 0.3, refused("machine.bodies[2] (r).radius", "0.3 m", given=0.3)),
        ("bodies.2.shape_factor", 1.5, refused("machine.bodies[2] (r).shape_factor", given=1.5, code="limits")),
        ("bodies.0.unbalance", 0.2, refused("machine.bodies[0] (drum).eccentricity", given=0.1)),
        ("bodies.0.eccentricity", None, refused("machine.bodies[0] (drum).eccentricity", given=None)),
        ("bodies.0.mass", -1.0, refused("machine.bodies[0] (drum).mass", "0 kg", given=-1.0, code="limits")),
        ("bodies.0.mass", "2 m", refused("machine.bodies[0] (drum).mass", code="dimension")),
        ("bodies.1.about", "drums", refused("machine.bodies[1] (p).about", "drum", given="drums")),
        ("bodies.1.name", "r", refused("machine.bodies", given="r")),
        ("bodies.1.name", "carrier", refused("machine.bodies[1].name", given="carrier")),
        ("bodies.1.lenght", 0.3, refused("machine.bodies[1] (p).lenght", "length", code="unknown-key")),
        ("bodies.1.kind", "pendel", refused("machine.bodies[1] (p).kind", "pendulum", code="unknown-name")),
        ("bodies.1.length", None, refused("machine.bodies[1] (p).length", code="missing")),
        ("carrier.stiffness", [4e3, -1.0], refused("machine.carrier.stiffness", given=[4000.0, -1.0])),
        ("carrier.stiffness", [4e3, 0.0], refused("machine.carrier.stiffness", given=[4000.0, 0.0])),
        ("carrier.directions", "y", refused("machine.carrier.stiffness", "directions = 'y'", given=[4000.0, 9000.0])),
        ("drive.on", "dram", refused("machine.drive.on", "drum", given="dram")),
        ("drive.slope", float("nan"), refused("machine.drive.slope", code="not-finite")),
    ],
)
def test_impossible_values_are_refused_with_place_and_remedy(path, value, refusal):
    with refusal:
        machine_from(changed(path, value))


def test_limits_themselves_are_allowed():
    """J = m e^2 is a point mass on a massless arm."""
    assert machine_from(changed("bodies.0.inertia", 0.02)).values["drum.inertia"] == 0.02
    assert machine_from(changed("bodies.1.inertia", 0.02)).values["p.inertia"] == 0.02
    assert machine_from(changed("bodies.2.shape_factor", 1.0)).values["r.shape_factor"] == 1.0


def test_bodies_may_not_turn_about_each_other_in_a_circle():
    with refused("machine.bodies[1] (p).about", given="r"):
        machine_from(changed("bodies.1.about", "r", changed("bodies.2.about", "p")))


def test_a_body_may_turn_about_a_body_that_turns_about_another():
    chain = machine_from(changed("bodies.2.about", "p"))
    assert [(b.name, b.about) for b in chain.bodies] == [("drum", None), ("p", "drum"), ("r", "p")]


def test_doubtful_machines_run_with_a_warning():
    weak = machine_from(changed("bodies.0.eccentricity", 0.2))
    assert any("more than the 0.15 kg m that its balancers can compensate" in w for w in weak.warnings)
    alone = changed("bodies", MACHINE["bodies"][:2])
    assert any("that its balancers can compensate" in w for w in machine_from(alone).warnings)
    assert machine_from(changed("bodies.0.eccentricity", 0.05)).warnings == ()
