"""Jobs, as OGC API – Processes 1.0 (18-062r2) describes them."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from pydantic import Field

from service.answers.base import Answer, Link

__all__ = ["JobList", "JobStatus", "StatusInfo"]

JobStatus = Literal["accepted", "running", "successful", "failed", "dismissed"]


class StatusInfo(Answer):
    """Where a job stands (statusInfo)."""

    jobID: str  # noqa: N815 # the contract's names
    processID: str  # noqa: N815
    type: Literal["process"] = "process"
    status: JobStatus
    message: str = Field(description="What is being done now, or why it failed.")
    progress: Annotated[int, Field(ge=0, le=100, description="Percent of the work that is done.")]
    created: datetime
    started: datetime | None = None
    finished: datetime | None = None
    updated: datetime
    links: list[Link]


class JobList(Answer):
    """Jobs, the latest first."""

    jobs: list[StatusInfo]
    links: list[Link]
