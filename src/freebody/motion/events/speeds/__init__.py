"""Short steps of the speeds alone, and the phases that follow them, in compiled code."""
