"""Loads on the links: what they ask of the machine at a state, their actions, and the sums of these."""
