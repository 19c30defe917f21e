"""Motion laws over the cam angle."""
