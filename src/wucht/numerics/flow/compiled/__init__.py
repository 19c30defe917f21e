"""The parts of the engine ``compiled``: coefficients, the stepper, and the translations of code to LLVM's instructions."""

from wucht.earlier_names import provide_earlier_names

provide_earlier_names(__name__)
