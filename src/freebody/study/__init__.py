"""Studies: how the motion depends on parameters and starts, and which parameters fit a measurement."""
