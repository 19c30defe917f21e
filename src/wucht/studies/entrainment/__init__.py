"""The study ``entrainment``: its question and the function that answers it."""

from wucht.studies.entrainment.study import Entrainment, entrainment

__all__ = ["Entrainment", "entrainment"]
