"""Derivatives of motions with contacts: variational equations, events, impacts."""
