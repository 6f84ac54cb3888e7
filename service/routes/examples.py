"""The built-in point sets: to try the service with, and to test against their truth."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Request
from pydantic import BaseModel, ConfigDict, Field
from starlette.responses import Response

from core.errors import InvalidParameter
from service.answers import ExampleAnswer, ExampleList, ExampleSummary, Link
from service.operations import problems
from service.problems import problem, respond
from service.render import negotiate
from service.routes.running import answer, run
from service.settings import Settings

__all__ = ["router"]

router = APIRouter(tags=["examples"])

FORMS = {"json": "application/json", "csv": "text/csv", "npy": "application/x-npy"}


class ExampleQuery(BaseModel):
    """What to draw, and how to write it; what is left out is the point set's own default."""

    model_config = ConfigDict(extra="forbid")

    n: int | None = Field(None, ge=1, description="Number of samples; outliers come on top.")
    sigma: float | None = Field(
        None, ge=0, description="Standard deviation of the noise, as a fraction of the diagonal."
    )
    outliers: float | None = Field(None, ge=0, description="Number of uniform outliers, as a fraction of n.")
    seed: int | None = Field(None, ge=0, le=2**32 - 1, description="The same seed, the same points.")
    format: Literal["json", "csv", "npy"] | None = Field(
        None, description="Form of the answer, instead of Accept."
    )

    def chosen(self) -> dict[str, Any]:
        """Return what is not left to the defaults."""
        return self.model_dump(exclude={"format"}, exclude_none=True)


@router.get(
    "/examples",
    operation_id="examples",
    summary="List the built-in point sets",
    response_model_exclude_none=True,
    responses=problems(429, 503),
)
async def examples(request: Request) -> ExampleList:
    """Name each point set, with what it shows and what it is drawn with by default."""
    rows = await run(request, "service.examples:catalogue")
    return ExampleList(
        examples=[ExampleSummary(**row, links=_links(row["name"])) for row in rows],
        links=[
            Link(href="/examples", rel="self", type="application/json"),
            Link(
                href="/reconstruct",
                rel="process",
                type="application/json",
                title="Post the points of an example here to get its curves back",
            ),
        ],
    )


def _form(accept: str | None) -> str:
    """Choose by ``Accept``: arrays are an example's own form, for those who name it."""
    return "npy" if FORMS["npy"] in (accept or "") else negotiate(accept, None, ("json", "csv"))


def _links(name: str) -> list[Link]:
    path = f"/examples/{name}"
    others = [
        Link(href=f"{path}?format={form}", rel="alternate", type=FORMS[form]) for form in ("csv", "npy")
    ]
    return [Link(href=path, rel="item", type=FORMS["json"]), *others]


@router.get(
    "/examples/{name}",
    operation_id="example",
    summary="Draw a built-in point set",
    response_class=Response,
    responses={
        200: {
            "description": "The points; as JSON with their truth.",
            "model": ExampleAnswer,
            "content": {
                "text/csv": {"schema": {"type": "string"}},
                "application/x-npy": {"schema": {"type": "string", "format": "binary"}},
            },
        },
        **problems(404, 406, 422, 429, 503),
    },
)
async def example(request: Request, name: str, query: Annotated[ExampleQuery, Query()]) -> Response:
    """Draw the points; as CSV or `.npy` they can be posted as they are."""
    settings: Settings = request.app.state.settings
    form = query.format or _form(request.headers.get("accept"))
    if (query.n or 0) * (1 + (query.outliers or 0)) > settings.max_points:
        error = InvalidParameter(f"at most {settings.max_points} points can be drawn", ("n",))
        return respond(request, problem(error, where=("query",)))
    return answer(
        request, await run(request, "service.examples:draw", name, query.chosen(), form, FORMS[form])
    )
