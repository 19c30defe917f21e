"""The study ``synchronous-states``: its question and the function that answers it."""

from wucht.studies.synchronous_states.study import SynchronousStates, synchronous_states

__all__ = ["SynchronousStates", "synchronous_states"]
