"""Steady phase configurations: torques.py states the balance, torus.py bounds it; closed_form.py and search.py
solve it and decide whether all are known; averaged_stability.py and full_stability.py decide which are stable.
"""
