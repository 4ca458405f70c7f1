"""Programs: recorded computations as machine code for one state or for many at once."""
