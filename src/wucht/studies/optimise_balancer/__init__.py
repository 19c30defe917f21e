"""The study ``optimise-balancer``: the best number, mass, place and damping of the balancing bodies of a machine."""
