"""The parts of the engine ``compiled``: coefficients, the stepper, and the translations of code to LLVM's instructions."""

from wucht.earlier_names import earlier_names

__getattr__ = earlier_names(__name__)
