"""The study ``approximation``: its question and the function that answers it."""

from wucht.studies.approximation.study import Approximation, approximation

__all__ = ["Approximation", "approximation"]
