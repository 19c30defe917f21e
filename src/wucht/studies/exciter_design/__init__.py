"""Study ``exciter-design``: motor, unbalances, damping and stiffness of a beating exciter for a given load spectrum."""
