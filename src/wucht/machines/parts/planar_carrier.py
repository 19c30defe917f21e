"""The planar rigid carrier: a body that translates and turns in its plane, such as a vibratory screen."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
import sympy as sp
from pydantic import Discriminator, Field, Tag

from wucht.errors import FieldError
from wucht.machines.parts.base import SI, Body, Frame, si
from wucht.machines.parts.mounts import GRAVITY, EqualMounts, Mount
from wucht.machines.parts.support import (
    NO_TUNING,
    Inertia,
    Pair,
    Support,
    is_negative,
    map_components,
    refuse_both,
    refuse_ratio_without_spring,
    refuse_rotation_both_ways,
    tuned_damping,
    tuned_rotation,
    tuned_stiffness,
    tuning_text,
)
from wucht.mechanics.energies import Energies
from wucht.schema import Composite, composite


def _form(mounts: Any) -> str:
    return "EqualMounts" if isinstance(mounts, Mapping | EqualMounts) else "Mount"


_Mounts = Annotated[  # the tags are the names of the tables, by which errors are located
    Annotated[tuple[Mount, ...], Tag("Mount")] | Annotated[EqualMounts, Tag("EqualMounts")], Discriminator(_form)
]


class PlanarCarrier(Support):
    """A rigid body with rotors at given positions, on mounts or on springs at its centre of mass.

    Its angle chi is small: a place (a, b) on it moves by (x - b chi, y + a chi), so that the carrier stays linear. Equal
    mounts share alike the stiffness and damping that follow from natural frequencies and damping ratios; those of given
    stiffness share the damping as they do the stiffness.
    """

    kind = "carrier-xyr"

    mass: SI[float] = si("kg", "mass", "m", gt=0, help="mass of the carrier without the bodies on it")
    inertia: SI[float] = si("kg m^2", "moment of inertia about the centre of mass", "J", gt=0)
    directions: Literal["xyr"] = Field(
        default="xyr", description="directions in which the carrier moves: x, y and a small rotation"
    )
    stiffness: SI[float | tuple[float, float] | None] = si("N/m", "stiffness", "c", default=None, help=(
        "stiffness of springs at the centre of mass, one number or a pair [x, y]; or give `mounts`"
    ))  # fmt: skip
    damping: SI[float | tuple[float, float]] = si(
        "N s/m", "damping", "b", default=0.0, help="viscous damping at the centre of mass, one number or a pair [x, y]"
    )
    rotation_stiffness: SI[float | None] = si(
        "N m", "rotation stiffness", "c_r", default=None, ge=0, help="stiffness against rotation"
    )
    rotation_damping: SI[float] = si(
        "N m s", "rotation damping", "b_r", default=0.0, ge=0, help="viscous damping of the rotation"
    )
    frequency: SI[float | tuple[float, float] | None] = si(
        "rad/s", "natural frequency with all bodies on it", "omega_0", default=None,
        help="natural frequency in x or y alone with all bodies on the carrier, from which the stiffness follows",
    )  # fmt: skip
    damping_ratio: SI[float | tuple[float, float] | None] = si(
        "",
        "damping ratio with all bodies on it",
        "zeta",
        default=None,
        help="damping ratio in x or y alone with all bodies on the carrier, from which the damping follows",
    )
    rotation_frequency: SI[float | None] = si(
        "rad/s", "natural frequency of the rotation with all bodies on it", default=None, ge=0
    )
    rotation_damping_ratio: SI[float | None] = si("", "damping ratio of the rotation with all bodies on it", default=None, ge=0)
    mounts: Composite[_Mounts] = composite(
        default=(),
        title="mounts",
        description="springs and dampers at places on the carrier, tables, or one table with a pattern",
    )

    @property
    def single_mounts(self) -> tuple[Mount, ...]:
        """The mounts; as they would be with a mass of 1 kg, where they are known by a pattern."""
        return self.mounts.mounts(1.0, GRAVITY) if isinstance(self.mounts, EqualMounts) else self.mounts

    def check(self) -> None:
        """Check for mounts, or stiffness and rotation_stiffness, none of them negative."""
        self.check_motion()
        if self.mounts and (self.stiffness is not None or self.rotation_stiffness is not None):
            raise FieldError("mounts", "give either mounts, or stiffness with rotation_stiffness", code="either-or")
        if not self.mounts and self.stiffness is None and self.frequency is None:
            raise FieldError(
                "stiffness", "this key is missing; give mounts, or stiffness and rotation_stiffness", code="missing"
            )
        self._check_tuning()
        pairs = [("stiffness", self.stiffness), ("damping", self.damping)]
        pairs += [("frequency", self.frequency), ("damping_ratio", self.damping_ratio)]
        pairs += [("mounts", v) for m in self.single_mounts for v in (m.stiffness, m.damping)]
        for key, value in pairs:
            if is_negative(value):
                quantity = key.replace("_", " ") if key in ("frequency", "damping_ratio") else "stiffness or damping"
                raise FieldError(key, f"must be a {quantity} of at least 0", code="limits")
        if self.mounts and not np.any(self.frequency or 0.0) and not any(np.any(m.stiffness) for m in self.single_mounts):
            raise ValueError("mounts", "there must be at least one mount with stiffness")

    def _check_tuning(self) -> None:
        """Check that each spring and damper is given in one way."""
        refuse_both(self, "stiffness", "frequency")
        refuse_both(self, "damping", "damping_ratio")
        refuse_rotation_both_ways(self)
        has_stiffness = [m.stiffness is not None for m in self.single_mounts]
        if self.frequency is not None and any(has_stiffness):
            raise FieldError(
                "frequency",
                "give either frequency, which all mounts share equally, or the stiffness of each mount",
                code="either-or",
            )
        if self.mounts and self.frequency is not None and np.any(self.damping):
            raise ValueError("damping", "not allowed with mounts: give the damping of each mount, or damping_ratio")
        if self.frequency is None and not all(has_stiffness):
            missing = f"mounts[{has_stiffness.index(False)}] has no stiffness"
            raise ValueError("mounts", f"{missing}; give that of each mount, or the carrier's frequency")
        if self.damping_ratio is not None and any("damping" in m.model_fields_set for m in self.single_mounts):
            raise FieldError(
                "damping_ratio",
                "give either damping_ratio, which the mounts share, or the damping of each mount",
                code="either-or",
            )
        rotation = [k for k in ("rotation_frequency", "rotation_damping_ratio") if getattr(self, k) is not None]
        if self.mounts and rotation:
            raise ValueError(rotation[0], "not allowed with mounts: how the carrier turns on them follows from their places")
        spring = self._total() if self.frequency is None else self.frequency
        refuse_ratio_without_spring("damping_ratio", self.damping_ratio, spring)

    def _total(self) -> Pair | None:
        """Return the stiffness in x and y of all springs together; None where none is given."""
        if not self.mounts:
            return self.stiffness
        whole: Pair = 0.0
        for mount in self.single_mounts:
            whole = map_components(operator.add, whole, mount.stiffness or 0.0)
        return whole

    def tune_springs(self, inertia: Inertia) -> tuple[Self, str]:
        """See ``Support``."""
        if isinstance(self.mounts, EqualMounts):
            of_all = inertia("x"), abs(self.gravity) or GRAVITY
            single, note = self.model_copy(update={"mounts": self.mounts.mounts(*of_all)}), self.mounts.note(*of_all)
            carrier, further_note = single.tune_springs(inertia)
            return carrier, "; ".join(filter(None, [note and f"carrier: {note}", further_note]))
        mass, notes, rotation = inertia("x"), list[str](), tuned_rotation(self, inertia)
        update: dict[str, Any] = rotation | NO_TUNING | {"frequency": None, "damping_ratio": None}
        if self.frequency is not None or self.damping_ratio is not None:
            whole = (self._total() or 0.0) if self.frequency is None else tuned_stiffness(mass, self.frequency)
            tuning = {} if self.frequency is None else {"stiffness": whole}
            if self.damping_ratio is not None:
                tuning["damping"] = tuned_damping(mass, whole, self.damping_ratio)
            update |= {"mounts": self._shared_mounts(tuning, whole)} if self.mounts else tuning
            notes.append(tuning_text(tuning, f"{mass:.6g} kg{' on all mounts together' if self.mounts else ''}"))
        if rotation:
            notes.append(tuning_text(rotation, f"{inertia('r'):.6g} kg m^2"))
        return self.model_copy(update=update), f"carrier: {'; '.join(notes)}" if notes else ""

    def _shared_mounts(self, tuning: Mapping[str, Pair], whole: Pair) -> tuple[Mount, ...]:
        """Return the mounts with their shares of the total values. whole: the total stiffness."""
        count, mounts = len(self.single_mounts), list[Mount]()
        for mount in self.single_mounts:
            stiffness = mount.stiffness if self.frequency is None else map_components(lambda c: c / count, whole)
            share = map_components(lambda c, of: c / of if of else 0.0, stiffness or 0.0, whole)
            update = {"stiffness": stiffness}
            if "damping" in tuning:
                update["damping"] = map_components(operator.mul, share, tuning["damping"])
            mounts.append(mount.model_copy(update=update))
        return tuple(mounts)

    def check_body(self, body: Body) -> None:
        """Accept bodies anywhere on it."""
        self.check_couple(body)

    def energies(self, frame: Frame) -> Energies:
        """T = m v^2/2 + J chi'^2/2; springs and dampers on the displacements of their places."""
        m, j = self.symbols("mass", "inertia")
        at, r = frame.centre, self.coordinates()[2]
        potential, dissipation = [m * frame.gravity * at.y], []
        for place, c, b in self._springs():
            p = self.axis_at(place)
            potential.append((c[0] * p.x**2 + c[1] * p.y**2) / 2)
            dissipation.append((b[0] * p.vx**2 + b[1] * p.vy**2) / 2)
        if not self.mounts:
            cr, br = self.symbols("rotation_stiffness", "rotation_damping")
            potential.append(cr * r.position**2 / 2 if self.rotation_stiffness is not None else sp.S.Zero)
            dissipation.append(br * r.velocity**2 / 2)
        return Energies(m * (at.vx**2 + at.vy**2) / 2 + j * r.velocity**2 / 2, sp.Add(*potential), sp.Add(*dissipation))

    def _springs(self) -> list[tuple[tuple[sp.Expr, sp.Expr], tuple[sp.Expr, ...], tuple[sp.Expr, ...]]]:
        """Return (place, (cx, cy), (bx, by)) of every spring."""
        if not self.mounts:
            c, b = (tuple(self.component(name, d) for d in "xy") for name in ("stiffness", "damping"))
            return [((sp.S.Zero, sp.S.Zero), c, b)]
        springs = []
        for i, mount in enumerate(self.single_mounts, 1):
            place = self.symbols(f"mounts.{i}.at.x", f"mounts.{i}.at.y")
            c, b = (self._component_symbols(f"mounts.{i}.{name}", getattr(mount, name)) for name in ("stiffness", "damping"))
            springs.append((place, c, b))
        return springs

    def _component_symbols(self, path: str, value: float | tuple[float, float]) -> tuple[sp.Expr, sp.Expr]:
        """Return the symbols of x and y; the same where one value holds for both."""
        x, y = self.symbols(f"{path}.x", f"{path}.y") if isinstance(value, tuple) else 2 * self.symbols(path)
        return x, y
