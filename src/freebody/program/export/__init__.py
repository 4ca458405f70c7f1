"""Programs in other languages: C, JAX, CasADi."""
