"""Bearings and balancing of rotors."""
