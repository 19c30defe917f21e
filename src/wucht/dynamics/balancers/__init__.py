"""Balancers: the evaluation of candidate designs, the best damping, and the steady states of their bodies."""
