"""The study ``load-spectrum``: count the load cycles of a machine's run-up, or of a record, and their damage to a part."""
