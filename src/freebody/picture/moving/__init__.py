"""Data of an animation at each moment: poses, forces, contacts."""
