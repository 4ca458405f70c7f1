"""Systems of the worked examples and sections of the textbook chapter."""
