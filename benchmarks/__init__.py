"""Cost, measured: ``make bench``. Ratios against a peer in the same run; times alone mean little."""
