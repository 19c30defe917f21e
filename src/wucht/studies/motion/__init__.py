"""What is seen of a motion while it runs, and what becomes of the machine."""
