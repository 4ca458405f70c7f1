"""Motion with contacts by time stepping (Moreau and Jean)."""
