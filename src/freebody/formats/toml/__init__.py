"""TOML model files, read and written."""
