"""The model: a machine assembled to frozen data."""

from .assemble import assemble
from .model import Coordinate, JointPlace, Link, Model, Place, Speed

__all__ = ["Coordinate", "JointPlace", "Link", "Model", "Place", "Speed", "assemble"]
