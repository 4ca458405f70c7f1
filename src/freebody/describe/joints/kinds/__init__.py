"""The kinds of joints, one file each: its data, its motions, and its door in `System`."""
