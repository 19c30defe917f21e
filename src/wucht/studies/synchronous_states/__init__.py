"""The study ``synchronous-states``: every steady phase configuration of a machine, its name and its stability."""
