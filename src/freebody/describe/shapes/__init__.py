"""Shapes by which bodies touch each other, one file each."""
