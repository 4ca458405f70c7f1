"""Systems of the problems of the textbook chapter."""
