"""Steady phase configurations: torques.py states the balance, torus.py bounds it; closed_form.py, force_balance.py, search.py
solve it and say whether these are all; slow_stability.py, full_stability.py, regions.py say which of them stay.
"""
