"""Stages of the loop of motions with contacts, in compiled code: those at events, and those of a phase."""
