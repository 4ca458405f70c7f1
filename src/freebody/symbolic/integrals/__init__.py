"""Conserved quantities, ignorable coordinates and symmetries, each with its proof."""
