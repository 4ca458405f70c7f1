"""Motion with contacts from event to event: stick, slip, roll, lift-off, impact."""
