"""What searches for a good machine share: the ranges of what is varied, and the search itself."""
