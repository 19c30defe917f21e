"""The study ``coast-down``: switch the drives off and see how the machine comes to rest."""
