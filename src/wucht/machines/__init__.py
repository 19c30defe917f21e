"""Machines: parts that state their energies, the files they are read from, and the catalogue."""
