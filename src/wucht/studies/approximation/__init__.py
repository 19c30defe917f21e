"""The study ``approximation``: deviations of the averaged equations from the full ones, and whether they may be trusted."""
