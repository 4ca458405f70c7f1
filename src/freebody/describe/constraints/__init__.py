"""Constraints of a system besides the joints of its tree: loops, conditions, gears, ropes."""
