"""The cam for a shaft that does not turn evenly: before, after, and what is left where the shaft turns otherwise: 004."""
