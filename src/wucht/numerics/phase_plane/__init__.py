"""The phase plane of autonomous Systems of two states, each a number or an angle: fixed points and the curves between them."""
