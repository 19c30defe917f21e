"""The separately excited DC motor."""

from __future__ import annotations

from typing import Any

import sympy as sp
from pydantic import GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from wucht.machines.parts.base import SI, Drive, si
from wucht.machines.parts.nameplate import DCNameplate, read_nameplate, required_without
from wucht.schema import Composite, composite

_LINE = ("armature_resistance", "motor_constant", "flux")  # the keys that follow from a nameplate


class DCSeparate(Drive):
    """A DC motor whose flux no armature current changes. A negative voltage reverses it: Drozdetskaya (2.85)-(2.92).

    Only k_M times the flux matters, in V s or N m/A.
    """

    kind = "dc-separate"

    nameplate: Composite[DCNameplate | None] = composite(
        default=None, description="rated data of the motor, from which its constants follow"
    )
    voltage: SI[float] = si("V", "voltage of the armature", "U_A", help=(
        "voltage of the armature; a negative one reverses the motor; beside a `nameplate` the operating voltage"
    ))  # fmt: skip
    armature_resistance: SI[float] = si("ohm", "resistance of the armature", "R_A", gt=0)
    motor_constant: SI[float] = si("", "motor constant", "k_M", gt=0, help=(
        "motor constant k_M: torque over flux and current; 1 where a data sheet gives only its product with the flux"
    ))  # fmt: skip
    flux: SI[float] = si("Wb", "magnetic flux of the field", "Phi_E", ge=0)

    @model_validator(mode="before")
    @classmethod
    def _line_of_the_nameplate(cls, table: Any) -> Any:
        table, plate = read_nameplate(table, DCNameplate, _LINE)
        if plate is None:
            return table
        flux, resistance = plate.line()
        constants = {"voltage": plate.voltage, "armature_resistance": resistance, "motor_constant": 1.0, "flux": flux}
        return constants | table

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return required_without(super().__get_pydantic_json_schema__(schema, handler), ("voltage", *_LINE))

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """002 (2.92), with k_M for the printed K_M, and without dividing by the flux, which may be zero."""
        U, R, k, flux = self.symbols("voltage", "armature_resistance", "motor_constant", "flux")
        return k * flux * (U - k * flux * speed) / R

    def circuit_loss(self, speed: sp.Expr) -> sp.Expr:
        """Return the heat in the armature, R_A I_A^2; that of the field, which has a supply of its own, is not counted."""
        U, R, k, flux = self.symbols("voltage", "armature_resistance", "motor_constant", "flux")
        return (U - k * flux * speed) ** 2 / R

    def derivation_notes(self) -> tuple[str, ...]:
        """Return the line that follows from the nameplate, and its deviations, as a note."""
        plate, line = self.nameplate, (self.motor_constant * self.flux, self.armature_resistance)
        return () if plate is None else (f"{self.path}: {plate.fit_text(*line)}",)

    def doubts(self) -> tuple[str, ...]:
        """Return the nameplate values that the line misses by more than a tenth."""
        plate, line = self.nameplate, (self.motor_constant * self.flux, self.armature_resistance)
        return () if plate is None else tuple(f"{self.path}.nameplate: {d}" for d in plate.doubts(*line))
