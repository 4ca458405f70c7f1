"""Free-body equations: the forces and moments on one isolated body, and its motion."""
