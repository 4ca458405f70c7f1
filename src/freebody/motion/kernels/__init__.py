"""Machine code that the integrators call: rates, energies, events of one machine."""
