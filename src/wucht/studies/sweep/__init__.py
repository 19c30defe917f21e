"""The study ``sweep``: its question and the function that answers it."""

from wucht.studies.sweep.study import Sweep, sweep

__all__ = ["Sweep", "sweep"]
