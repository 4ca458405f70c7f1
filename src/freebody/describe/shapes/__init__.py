"""Shapes by which bodies touch each other, one file each."""

from . import circle, corners, cylinder, ellipsoid, heightline, plane, segment, solid, sphere  # noqa: F401
