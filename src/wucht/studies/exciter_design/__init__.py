"""The study ``exciter-design``: motor, unbalances, damping and stiffness with which a beating exciter gives a load spectrum."""
