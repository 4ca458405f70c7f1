"""Taylor series of a motion as machine code."""
