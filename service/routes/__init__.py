"""The routes: thin, each reads, runs and answers."""

from __future__ import annotations

from service.routes.examples import router as examples
from service.routes.health import router as health
from service.routes.jobs import router as jobs
from service.routes.landing import router as landing
from service.routes.ogc import ogc
from service.routes.processes import processes

__all__ = ["examples", "health", "jobs", "landing", "ogc", "processes"]
