"""Free-body equations: the forces on one isolated body and what they do to it."""
