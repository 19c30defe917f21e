"""Study that sets several machines or variants side by side, in one result."""
