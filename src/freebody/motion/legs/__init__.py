"""Interruptions of a motion: blows, drives, signals, controllers, singular positions, one-sided limits."""
