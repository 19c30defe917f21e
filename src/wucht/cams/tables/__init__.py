"""The tables of a cam file, checked when they are built, and what is made of them."""
