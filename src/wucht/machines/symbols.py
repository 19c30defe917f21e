"""The symbols in which a machine's equations are printed."""

from __future__ import annotations

from collections import Counter

from wucht.machines.machine import Machine
from wucht.mechanics.notation import Notation


def notation_of(machine: Machine) -> Notation:
    """Return phi for rotors, theta for bodies that turn about another, xi and eta for the axis of dimensionless machines.

    Parameters have the symbol of their field, with the name of their part as an index where two parts have the same.
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
    several = {path: p.symbol for path, p in machine.parameters.items() if count[p.symbol] > 1}
    names |= {path: p.symbol for path, p in machine.parameters.items() if path not in several}
    for owner_of in (_name, _list_entry, str):  # the shortest index that no other symbol has
        new_names = {path: f"{symbol.replace('_', '')}_{owner_of(path)}" for path, symbol in several.items()}
        count = Counter((*names.values(), *new_names.values()))
        names |= {path: name for path, name in new_names.items() if count[name] == 1}
        several = {path: symbol for path, symbol in several.items() if path not in names}
    return Notation(names)


_LISTS = ("drives.", "loads.", "tracks.", "carrier.mounts.")


def _name(path: str) -> str:
    """The name of the part to which a parameter belongs: of a mount its number, of ``drives.e1`` the body."""
    head = next((h for h in _LISTS if path.startswith(h)), "")
    return path.removeprefix(head).partition(".")[0]


def _list_entry(path: str) -> str:
    """The same with the list in which the part is."""
    head = next((h for h in _LISTS if path.startswith(h)), "")
    return head + _name(path)
