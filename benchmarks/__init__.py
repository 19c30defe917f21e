"""Cost, measured: ``make bench``. Ratios against a peer in the same run; times on a shared machine mean little by themselves."""
