"""The long computations of the core, and how each falls into parts: groups of components."""

from __future__ import annotations

from core import methods

__all__ = ["DIAGNOSE", "PCA", "RECONSTRUCT", "SKELETON"]

PCA = methods.PCA.division
SKELETON = methods.SKELETON.division
RECONSTRUCT = methods.RECONSTRUCT.division
DIAGNOSE = methods.DIAGNOSE.division
