"""Blocks of lanes: where and in which order they run."""
