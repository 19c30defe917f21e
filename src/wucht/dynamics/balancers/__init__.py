"""Balancers: what candidates of one are worth, the best damping, and the states in which their bodies rest."""
