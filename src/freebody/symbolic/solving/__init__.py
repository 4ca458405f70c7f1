"""Solution of the equations for chosen unknowns."""
