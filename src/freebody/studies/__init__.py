"""Studies: sweeps over parameters and initial values, fits to measurements, and the analysis of a machine."""
