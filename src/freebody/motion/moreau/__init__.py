"""The compiled loop of time stepping: steps of Moreau and Jean, and what each is made of."""
