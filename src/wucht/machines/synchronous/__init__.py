"""Constant phases of a machine: torques.py states the balance, torus.py bounds it; closed.py, polygon.py, search.py solve."""
