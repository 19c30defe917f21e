"""The parts of the engine ``compiled``: coefficients, the stepper, and the translations of code to LLVM's instructions."""
