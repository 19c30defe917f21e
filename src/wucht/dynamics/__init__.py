"""Engines between a machine and a study: run-ups and their verdicts, branches, ensembles. They know no spec and no figure."""
