"""Many starts, variants and candidates of a machine: ensembles and searches."""
