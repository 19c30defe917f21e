"""The study ``torque-balance``: its question and the function that answers it."""

from wucht.studies.torque_balance.study import TorqueBalance, torque_balance

__all__ = ["TorqueBalance", "torque_balance"]
