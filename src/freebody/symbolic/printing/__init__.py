"""Printing of canonical polynomials and of results: text, LaTeX, MathML, SymPy."""
