"""What runs but is doubtful: said as a warning, never as an error."""

from __future__ import annotations

from collections.abc import Sequence

from wucht.machines.parts.base import Body


def doubts(bodies: Sequence[Body]) -> tuple[str, ...]:
    """Sentences about a machine that its balancers cannot balance."""
    found = []
    bodies = [b for b in bodies if b.turns()]
    for rotor in (b for b in bodies if b.reference is None):
        own = rotor.number(rotor.moment())
        balancers = [b.number(b.moment()) for b in bodies if b.reference == rotor.name]
        if balancers and own > sum(balancers):
            found.append(
                f"the unbalance of {rotor.name!r} is {own:.4g} kg m, more than the {sum(balancers):.4g} kg m that its "
                "balancers can compensate together; they can only reduce it"
            )
        largest = max(balancers, default=0.0)
        if len(balancers) > 1 and largest > own + sum(balancers) - largest:
            found.append(
                f"one balancer of {rotor.name!r} has {largest:.4g} kg m, more than the rotor and all other balancers "
                "together: they cannot compensate each other"
            )
        if len(balancers) == 1 and own > 0 and abs(largest - own) > 0.01 * own:
            found.append(
                f"{rotor.name!r} has one balancer, of {largest:.4g} kg m: one body compensates only an unbalance equal "
                f"to its own, and the rotor's is {own:.4g} kg m"
            )
    return tuple(found)
