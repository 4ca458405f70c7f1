"""Systems beyond the textbook chapter."""
