"""Analysis of a machine: its equations, conserved quantities, steady motions and small motions."""
