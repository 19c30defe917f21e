"""Many starts and parameter sets of one System, integrated together and watched while they run."""
