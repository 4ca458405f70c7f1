"""Linear models about an operating point: modes, response, state space."""
