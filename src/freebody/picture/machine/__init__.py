"""Drawing of a machine: bodies, joints, loads, ground, coordinates."""
