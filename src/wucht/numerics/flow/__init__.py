"""System -> motion: compiled once a structure, integrated as often as one likes, by heyoka or SciPy."""
