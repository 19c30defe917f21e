"""A machine integrated from an initial state, and observed."""
