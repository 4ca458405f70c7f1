"""Systems of the textbook chapter; each file is named after the number and the name of its system."""
