"""The web service: bodies in, :mod:`core` called in worker processes, answers out."""

from __future__ import annotations

__all__ = ["__version__"]

__version__ = "0.1.0"
