"""Families of contacts as data: which pairs touch at a configuration, and the rows of those that do."""
