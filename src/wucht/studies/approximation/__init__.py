"""The study ``approximation``: how far the averaged equations are from the full ones, and whether they may be trusted."""
