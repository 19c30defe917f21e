"""The study ``coast-down``: its question and the function that answers it."""

from wucht.studies.coast_down.study import CoastDown, coast_down

__all__ = ["CoastDown", "coast_down"]
