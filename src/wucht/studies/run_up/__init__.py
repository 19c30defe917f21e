"""The study ``run-up``: start the machine and follow its motion to the end."""
