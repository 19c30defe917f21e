"""Fields of parts: see ``wucht.fields``."""

from wucht.fields import Described, Parameter, si, unit_of

__all__ = ["Described", "Parameter", "si", "unit_of"]
