"""Files: TOML to machines and back to sentences about what is wrong in them; the catalogue."""
