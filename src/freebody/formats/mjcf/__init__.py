"""Robots in MJCF, the format of MuJoCo."""
