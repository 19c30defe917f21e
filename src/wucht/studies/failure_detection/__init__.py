"""The study ``failure-detection``: a specimen fails, its exciter changes speed, and a slow sensor of that sees it."""
