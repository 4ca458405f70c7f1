"""Systems of the textbook chapter; each file has the number and the name of its system."""
