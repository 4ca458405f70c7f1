"""Start of a motion: the user's names and values become a state that satisfies the constraints."""
