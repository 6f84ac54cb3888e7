"""Tables of few processes: a service of them is warm sooner."""

from __future__ import annotations

from service.processes import PROCESSES

__all__ = ["LIGHT", "WHOLE"]

LIGHT = tuple(row for row in PROCESSES if row.id in {"partition", "reconstruct-pca"})
WHOLE = tuple(row for row in PROCESSES if row.id in {"partition", "reconstruct"})
