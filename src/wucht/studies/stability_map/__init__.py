"""The study ``stability-map``: where in a plane of parameters steady states and modulated motions exist, and are stable."""
