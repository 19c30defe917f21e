"""Constant phases of a machine: torques.py states the balance; closed.py, polygon.py and search.py solve it."""
