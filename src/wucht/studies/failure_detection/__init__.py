"""Study ``failure-detection``: a specimen fails, its exciter changes speed, and a slow sensor of the speed detects it."""
