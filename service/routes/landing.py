"""The landing document: where everything is, as JSON for programs and as a page for people."""

from __future__ import annotations

from html import escape

from fastapi import APIRouter, FastAPI, Request
from starlette.responses import HTMLResponse, JSONResponse, Response

from service.answers import Landing, Link
from service.ogc import LINKS
from service.processes import Process

__all__ = ["router"]

router = APIRouter(tags=["operations"])

_LINKS = (
    Link(href="/examples", rel="examples", type="application/json", title="Built-in point sets to try"),
    Link(href="/docs", rel="service-doc", type="text/html", title="Documentation to read and to try"),
    Link(
        href="/openapi.json",
        rel="service-desc",
        type="application/vnd.oai.openapi+json;version=3.1",
        title="The same for programs (OpenAPI)",
    ),
    Link(href="/healthz", rel="status", type="application/json", title="Whether the server lives"),
    Link(href="/readyz", rel="status", type="application/json", title="Whether the workers are warm"),
)


@router.get(
    "/",
    operation_id="landing",
    summary="Tell where everything is",
    response_class=Response,
    responses={
        200: {
            "description": "Links",
            "model": Landing,
            "content": {"text/html": {"schema": {"type": "string"}}},
        },
    },
)
async def landing(request: Request) -> Response:
    """Answer with links; browsers get a page."""
    document = _document(request.app)
    headers = {"Vary": "Accept"}
    if "text/html" in request.headers.get("accept", ""):  # who names it can show it
        return HTMLResponse(_page(document), headers=headers)
    return JSONResponse(document.model_dump(exclude_none=True), headers=headers)


def _document(app: FastAPI) -> Landing:
    table: tuple[Process, ...] = app.state.processes
    posts = [Link(href=row.path, rel="process", type="application/json", title=row.title) for row in table]
    return Landing(
        title=app.title, description=app.summary or "", version=app.version, links=[*posts, *LINKS, *_LINKS]
    )


def _page(document: Landing) -> str:
    rows = "\n".join(_row(link) for link in document.links)
    return _PAGE.format(
        title=escape(document.title),
        description=escape(document.description),
        version=escape(document.version),
        rows=rows,
    )


def _row(link: Link) -> str:
    title = escape(link.title or link.href)
    if link.rel == "process":  # is posted to: a browser that follows it would be told 405
        return f"<li><code>POST {escape(link.href)}</code> {title}</li>"
    return f'<li><a href="{escape(link.href)}"><code>{escape(link.href)}</code></a> {title}</li>'


_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
:root {{ color-scheme: light dark }}
body {{ font: 1rem/1.6 system-ui, sans-serif; max-width: 46rem; margin: 3rem auto; padding: 0 1rem }}
li {{ margin: .4rem 0 }}
pre {{ overflow-x: auto; padding: .8rem; border: 1px solid }}
</style>
</head>
<body>
<h1>{title} <small>{version}</small></h1>
<p>{description}</p>
<ul>
{rows}
</ul>
<p>Draw a noisy spiral and reconstruct it, as a picture:</p>
<pre>curl -s 'http://127.0.0.1:8000/examples/spiral?format=csv' |
  curl -s -H 'Content-Type: text/csv' --data-binary @- \\
  'http://127.0.0.1:8000/reconstruct?format=svg' -o spiral.svg</pre>
</body>
</html>
"""
