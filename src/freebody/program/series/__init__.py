"""Taylor series of a motion as machine code.

Bottom up: recurrence, factors, rewriting, combining, writer, then jet (one motion) and jet_of_lanes (eight motions).
"""
