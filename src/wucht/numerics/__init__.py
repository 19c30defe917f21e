"""System -> numbers. Knows no machine: someone with another ODE can use this folder alone."""
