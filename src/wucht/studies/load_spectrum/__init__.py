"""The study ``load-spectrum``: count what a machine's run-up, or a record, does to a part."""
