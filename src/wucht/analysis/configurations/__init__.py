"""Steady phase configurations: torques.py states the balance, torus.py bounds it; closed_form.py and search.py
solve it and say whether these are all; averaged_stability.py and full_stability.py say which of them stay.
"""
