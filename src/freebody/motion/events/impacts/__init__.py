"""Impacts at contacts, and the rests in which series of them end, in compiled code."""
