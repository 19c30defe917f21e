"""Engines between a machine and a study: run-ups and their verdicts, branches, ensembles. They use no spec and no figure."""
