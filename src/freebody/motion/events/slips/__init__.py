"""Slips in space at speed zero, in compiled code: their first and last moments, as straight steps."""
