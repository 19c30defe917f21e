"""The study ``synchronous-states``: all steady phase configurations of a machine, with names and stability."""
