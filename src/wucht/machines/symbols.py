"""The symbols in which a machine's equations are printed."""

from __future__ import annotations

from collections import Counter

from wucht.machines.machine import Machine
from wucht.mechanics.notation import Notation


def notation_of(machine: Machine) -> Notation:
    """Return phi for rotors, theta for bodies that turn about another, xi and eta for the axis of dimensionless machines.

    Parameters carry the symbol of their field, and the name of their part where two parts have the same.
    """
    letters = {"r": "chi", "foundation": "z"}
    names = {c.position.name: letters.get(label, label) for label, c in zip(machine.labels, machine.carrier, strict=True)}
    if machine.dimensionless:
        names = {c.position.name: {"x": "xi", "y": "eta"}[c.position.name[-1]] for c in machine.carrier}
    rotors = sum(b.about is None for b in machine.bodies)
    for b in machine.bodies:
        base = "phi" if b.about is None else "theta"
        names[b.coordinate.position.name] = "phi" if b.about is None and rotors == 1 else f"{base}_{b.name}"
    for x in machine.sliders:
        names[x.coordinate.position.name] = f"s_{x.name}"
    names |= {x.state.name: f"{x.description.letter}_{x.path}" for x in machine.internal}
    count = Counter(p.symbol for p in machine.parameters.values())
    alike = Counter((p.symbol, path.split(".")[0]) for path, p in machine.parameters.items())
    for path, p in machine.parameters.items():
        owner = path.split(".")[0]
        if alike[p.symbol, owner] > 1:  # several parts in a list, such as mounts or drives: the place in it belongs to the name
            owner = ".".join(path.split(".")[: 3 if path.startswith("carrier.") else 2])
        names[path] = p.symbol if count[p.symbol] == 1 else f"{p.symbol.replace('_', '')}_{owner}"
    return Notation(names)
