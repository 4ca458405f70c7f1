"""Machines with gears, and wheels that drive."""
