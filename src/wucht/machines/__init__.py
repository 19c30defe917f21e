"""Machines: parts that state their energies, who turns about whom, schedules and tracks; the data of the catalogue."""
