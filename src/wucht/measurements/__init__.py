"""Measured records -> numbers: reading files, speed of a shaft, orders by least squares, order tracking. Knows no machine."""
