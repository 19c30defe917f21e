"""From the motion of a machine to its outcome: what is observed, the evidence, the criteria."""
