"""Programs: the dynamics of a machine as machine code for one state or for many at once."""
