"""The study ``run-up``: its question and the function that answers it."""

from wucht.studies.run_up.study import RunUp, run_up

__all__ = ["RunUp", "run_up"]
