"""The study ``run-up``: start the machine and see what becomes of it."""
