"""Motion of a machine: simulation, events, trajectory, batches."""
