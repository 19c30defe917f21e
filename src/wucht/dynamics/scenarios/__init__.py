"""What happens to a running machine: a drive fails, the supply is switched off, pendulums open. Runs that follow each other."""
