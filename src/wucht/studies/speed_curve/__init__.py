"""The study ``speed-curve``: how the speed of steady operation, and every other state, depends on a parameter."""
