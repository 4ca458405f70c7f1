"""Numbers: algebra on every scalar type, canonical polynomials, recorded traces, derivatives."""
