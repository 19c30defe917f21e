"""Sweeps of a parameter of a running machine: their pace, the averages over turns, and the ends of branches."""
