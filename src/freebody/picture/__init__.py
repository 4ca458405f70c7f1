"""Pictures: drawings, free-body diagrams, plots, animations and pages."""
