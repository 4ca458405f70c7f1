"""Motions as files: what is written and read, and files of results that are replaced whole."""
