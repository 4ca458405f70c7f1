"""Motion with contacts in time steps: what a run needs before the compiled loop (`moreau`), and the motion from it."""
