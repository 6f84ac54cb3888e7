"""The long computations of the core, and how each falls into parts: groups of components, or of levels."""

from __future__ import annotations

from core import methods
from core.surface import methods as surface

__all__ = ["CONTOURS", "DIAGNOSE", "PCA", "RECONSTRUCT", "SKELETON", "SURFACE"]

PCA = methods.PCA.division
SKELETON = methods.SKELETON.division
RECONSTRUCT = methods.RECONSTRUCT.division
DIAGNOSE = methods.DIAGNOSE.division
CONTOURS = surface.CONTOURS
SURFACE = surface.SURFACE
