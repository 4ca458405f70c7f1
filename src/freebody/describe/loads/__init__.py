"""Loads of a system: forces, torques, springs, dampers."""
