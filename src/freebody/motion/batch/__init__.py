"""The lanes of a batch, run in this process."""
