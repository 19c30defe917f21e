"""The table [study.contact]: inertia, spring and load of the follower, width and materials of the contact."""

from __future__ import annotations

from pydantic import Field

from wucht.cams.contact import FollowerLoad, Material
from wucht.cams.drive import CamDrive
from wucht.errors import InputError
from wucht.schema import SI, TableModel, Unit, read_quantity, si
from wucht.schema.key_values import Value

_QUANTITIES = {
    "rad": {
        "preload": Unit("N m", "preload of a follower that turns"),
        "stiffness": Unit("N m/rad", "torsional stiffness of a follower that turns"),
        "damping": Unit("N m s/rad", "torsional damping of a follower that turns"),
        "constant": Unit("N m", "constant load of a follower that turns"),
    },
    "m": {
        "preload": Unit("N", "preload of a follower that slides"),
        "stiffness": Unit("N/m", "stiffness of a follower that slides"),
        "damping": Unit("N s/m", "damping of a follower that slides"),
        "constant": Unit("N", "constant load of a follower that slides"),
    },
}


class Contact(TableModel):
    """Inertia, spring and load of the follower; for a lever about its pivot, for a rod along its axis."""

    inertia: SI[float | None] = si("kg m^2", "moment of inertia of the follower", default=None, ge=0, help=(
        "moment of inertia of a lever about its pivot, in kg m^2"
    ))  # fmt: skip
    mass: SI[float | None] = si("kg", "mass of the follower", default=None, ge=0, help="mass of a rod, in kg")
    output_inertia: SI[float | None] = si("kg m^2", "moment of inertia of the output", default=None, ge=0, help=(
        "moment of inertia of an output behind a linkage, in kg m^2"
    ))  # fmt: skip
    output_mass: SI[float | None] = si(
        "kg", "mass of the output", default=None, ge=0, help="mass of an output behind a linkage"
    )
    preload: Value = Field(default=0.0, title="preload", description=(
        "torque or force (N m or N) with which a spring presses the roller on the cam where the law is zero; for two "
        "cams, with which they squeeze the lever"
    ))  # fmt: skip
    stiffness: Value = Field(
        default=0.0, title="stiffness of the spring", description="stiffness of this spring, in N m/rad or N/m"
    )
    damping: Value = Field(default=0.0, title="damping", description="viscous damping of the follower, in N m s/rad or N s/m")
    constant: Value = Field(
        default=0.0,
        title="constant load",
        description="constant load (N m or N) against the sense in which the law rises, as a weight",
    )
    share: SI[float] = si("", "share of the cam in the driving torque", default=0.5, ge=0, le=1, help=(
        "of two cams, share of the driving torque that raises the force on the cam; the rest lowers that on the counter cam"
    ))  # fmt: skip
    width: SI[float | None] = si(
        "m", "width of the contact", default=None, gt=0, help="width of the contact; with it the Hertzian pressure is computed"
    )
    modulus: SI[float] = si("Pa", "Young's modulus of the cam", default=210e9, gt=0)
    poisson: SI[float] = si("", "Poisson's ratio of the cam", default=0.3, gt=-1, le=0.5)
    roller_modulus: SI[float | None] = si("Pa", "Young's modulus of the roller", default=None, gt=0, help=(
        "Young's modulus of the roller or face, where it differs from the cam's"
    ))  # fmt: skip
    roller_poisson: SI[float | None] = si("", "Poisson's ratio of the roller", default=None, gt=-1, le=0.5, help=(
        "Poisson's ratio of the roller or face, where it differs from the cam's"
    ))  # fmt: skip

    def follower_load(self, drive: CamDrive) -> FollowerLoad:
        """Return the load on the follower of a drive. Raises ``InputError``, located in this table."""
        unit = drive.required_follower.unit
        inertia_key, inertia = self._moved_inertia(unit, "follower")
        if inertia is None:
            quantity = "moment of inertia in kg m^2 about its pivot" if unit == "rad" else "mass in kg"
            raise InputError(inertia_key, None, f"this key is missing; give the follower's {quantity}", code="missing")
        quantities = {key: read_quantity(of, getattr(self, key), key) for key, of in _QUANTITIES[unit].items()}
        return FollowerLoad(inertia, **quantities, output_inertia=self._output_inertia(drive))

    def _moved_inertia(self, unit: str, part: str) -> tuple[str, float | None]:
        """Return the key of the inertia or mass of a follower or output, and its value; the excluded key must not be given."""
        prefix = "output_" if part == "output" else ""
        inertia_key, excluded_key = (prefix + kind for kind in (("inertia", "mass") if unit == "rad" else ("mass", "inertia")))
        if getattr(self, excluded_key) is not None:
            turns = "turns: give its inertia in kg m^2" if unit == "rad" else "slides: give its mass in kg"
            raise InputError(excluded_key, getattr(self, excluded_key), f"the {part} {turns}")
        return inertia_key, getattr(self, inertia_key)

    def _output_inertia(self, drive: CamDrive) -> float:
        """Return the inertia or mass that a linkage moves, in kg m^2 or kg."""
        if drive.linkage is not None:
            return self._moved_inertia(drive.motion_law.unit, "output")[1] or 0.0
        for key in ("output_inertia", "output_mass"):
            if getattr(self, key) is not None:
                requirement = "without a linkage the follower is the output: add this value to that of the follower"
                raise InputError(key, getattr(self, key), requirement)
        return 0.0

    @property
    def materials(self) -> tuple[Material, Material]:
        """The materials of the cam and of the roller or face."""
        roller_modulus = self.modulus if self.roller_modulus is None else self.roller_modulus
        roller_poisson = self.poisson if self.roller_poisson is None else self.roller_poisson
        return Material(self.modulus, self.poisson), Material(roller_modulus, roller_poisson)
