"""What every answer must be like."""

from __future__ import annotations

from typing import Any

import httpx

from service.answers import ProblemDocument


def is_problem(response: httpx.Response, status: int, kind: str | None = None) -> dict[str, Any]:
    """Check a problem document, and return it."""
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    document: dict[str, Any] = response.json()
    ProblemDocument.model_validate(document)
    assert document["status"] == status
    assert kind in {None, document["type"]}
    assert document["instance"].removeprefix("urn:uuid:") == response.headers["x-request-id"]
    assert "Traceback" not in response.text
    return document
