"""Products of a model in other languages: recorded, then written as C, as NumPy or JAX source, or for CasADi."""
