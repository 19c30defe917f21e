"""The study ``approximation``: how far the slow equations are from the full ones, and whether they may be trusted."""
