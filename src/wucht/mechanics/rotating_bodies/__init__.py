"""Averaged equations of rotating bodies on a linear carrier."""
