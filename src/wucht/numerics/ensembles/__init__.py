"""Many starts and parameter sets of one System, integrated together and observed while they run."""
