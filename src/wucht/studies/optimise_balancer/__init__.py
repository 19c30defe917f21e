"""The study ``optimise-balancer``: number, mass, place and damping of the balancing bodies that serve a machine best."""
