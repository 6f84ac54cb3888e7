"""The settings of the service, each declared once.

They come from environment variables with the prefix ``TAPELINE_``, or from a
file ``.env`` in the working directory; the environment wins.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

__all__ = ["Settings"]


def _cores() -> int:
    """Count the cores that this process may use, which in a container are fewer than the machine has."""
    affinity = getattr(os, "sched_getaffinity", None)  # not on macOS
    return len(affinity(0)) if affinity else os.cpu_count() or 1


class Settings(BaseSettings):
    """Everything that an operator can set."""

    model_config = SettingsConfigDict(env_prefix="TAPELINE_", env_file=".env", extra="ignore", frozen=True)

    host: str = Field("127.0.0.1", description="Address to listen on; 0.0.0.0 for every interface.")
    port: int = Field(8000, ge=0, le=65535, description="Port to listen on; 0 for any free one.")
    data_dir: Path = Field(
        Path("data"),
        description="Directory for what the service keeps between runs: now font lists and, when the "
        "package's own folder is read-only, compiled kernels. When it cannot be written, a temporary "
        "directory takes its place.",
    )
    workers: int = Field(
        default_factory=_cores,
        ge=1,
        description="Processes that compute. Default: as many as there are cores.",
    )
    queue_length: int = Field(
        16, ge=0, description="Requests that may wait for a free worker; one more is answered 429."
    )
    max_points: int = Field(
        2_000_000, ge=1, description="Largest number of points of a request; more are 413."
    )
    max_bytes: int = Field(
        128 * 1024 * 1024,
        ge=1,
        description="Largest body in bytes, as sent and after decompression; larger ones are 413.",
    )
    deadline_seconds: float = Field(
        60.0,
        gt=0,
        allow_inf_nan=False,
        description="Seconds for waiting and computing together; then the work is stopped: 503.",
    )
    cors_origins: Annotated[tuple[str, ...], NoDecode] = Field(
        (),
        description="Origins whose pages may call the service, separated by commas; * for all.",
    )
    log_level: Literal["critical", "error", "warning", "info", "debug"] = Field(
        "info", description="Least severity that is logged."
    )

    @field_validator("cors_origins", mode="before")
    @classmethod
    def _split(cls, value: object) -> object:
        """Accept ``a, b`` where JSON would be a nuisance to quote in a shell."""
        if isinstance(value, str):
            return tuple(part.strip() for part in value.split(",") if part.strip())
        return value
