"""Contact problems in Coulomb's cones, and the ways to solve them: sweeps, and Newton's method from compliance."""
