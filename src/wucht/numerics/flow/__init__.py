"""System -> motion: compiled once per structure, integrated any number of times, by heyoka or SciPy."""
