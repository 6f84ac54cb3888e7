"""Whether the process lives, and whether it can take work."""

from __future__ import annotations

from fastapi import APIRouter, Request

from service.answers import Health, Readiness
from service.errors import NotReady
from service.operations import problems
from service.work import Pool

__all__ = ["router"]

router = APIRouter(tags=["operations"])


@router.get("/healthz", operation_id="healthz", summary="Tell whether the server lives")
async def healthz() -> Health:
    """Answer at once, whatever the workers do."""
    return Health()


@router.get(
    "/readyz", operation_id="readyz", summary="Tell whether the workers are warm", responses=problems(503)
)
async def readyz(request: Request) -> Readiness:
    """Answer 503 until every worker has been warm once, and whenever none is."""
    pool: Pool = request.app.state.pool
    if not pool.ready or not pool.warm:
        raise NotReady("the workers are still starting; requests wait for them", retry_after=2)
    return Readiness(workers=pool.warm)
