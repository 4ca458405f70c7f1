"""Result of a simulation: values over time, events, phases, files."""
