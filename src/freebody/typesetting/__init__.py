"""Formulas as outlines of letters: LaTeX in, boxes of glyphs out. It knows no machines."""
