"""Symbolic products of a model: free-body equations, reactions, equations of motion, energy, momentum."""

from .equations import Equations, equations
from .free_body import Action, FreeBody
from .reaction import Reaction

__all__ = ["Action", "Equations", "FreeBody", "Reaction", "equations"]
