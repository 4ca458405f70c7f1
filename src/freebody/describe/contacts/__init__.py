"""Contacts of a system: features that may touch, and their laws."""
