"""Description of a machine: bodies, joints, loads, contacts and constraints of a `System`."""
