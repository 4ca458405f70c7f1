"""Joints of a system."""
