"""The settings of the service, each declared once.

They come from environment variables with the prefix ``TAPELINE_``, or from a
file ``.env`` in the working directory; the environment wins.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

__all__ = ["Settings"]

_KIBI = 1024


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
        description="Directory for what the service keeps between runs: jobs with their inputs and results "
        "(unless the two addresses below say otherwise), font lists and, when the package's own folder is "
        "read-only, compiled kernels. When it cannot be written, a temporary directory takes its place.",
    )
    database_url: str | None = Field(
        None,
        description="Database of the jobs: postgresql://user:password@host/name for several machines. "
        "Default: a SQLite file in the data directory.",
    )
    store_url: str | None = Field(
        None,
        description="Where inputs and results of jobs lie, as an fsspec address; several machines need one "
        "that they share. Default: a folder in the data directory.",
    )
    workers: int = Field(
        default_factory=_cores,
        ge=1,
        description="Processes that compute what is answered at once. Default: as many as there are cores.",
    )
    queue_length: int = Field(
        16, ge=0, description="Requests that may wait for a free worker; one more is answered 429."
    )
    job_workers: int = Field(
        default_factory=_cores,
        ge=0,
        description="Jobs computed at a time, each in a process of its own; 0 leaves them to "
        "`tapeline worker` on other machines. Default: as many as there are cores.",
    )
    job_queue_length: int = Field(
        1000, ge=0, description="Jobs that may wait to be computed; one more is answered 429."
    )
    job_poll_seconds: float = Field(
        0.05,
        gt=0,
        le=60,
        description="Seconds between two looks of a worker at the queue of jobs; many workers on one "
        "database may look less often.",
    )
    job_bytes: int = Field(
        8 * _KIBI**2,
        ge=0,
        description="Bodies of more bytes are computed as jobs, also when the client waits for the answer.",
    )
    job_seconds: float = Field(
        3600.0, gt=0, allow_inf_nan=False, description="Seconds that a job may compute; then it fails."
    )
    job_memory: int = Field(
        8 * _KIBI**3, ge=64 * _KIBI**2, description="Bytes of memory that a job may take; then it fails."
    )
    keep_seconds: float = Field(
        7 * 24 * 3600.0,
        gt=0,
        allow_inf_nan=False,
        description="Seconds that a finished job and its results are kept.",
    )
    keep_bytes: int = Field(
        10 * _KIBI**3,
        ge=0,
        description="Bytes that inputs and results may take in all; beyond, finished jobs go, oldest first.",
    )
    max_points: int = Field(
        2_000_000,
        ge=1,
        description="Largest number of points of a request, four holes of range images counting as one; more "
        "are 413.",
    )
    max_bytes: int = Field(
        128 * _KIBI**2,
        ge=1,
        description="Largest body in bytes, as sent and after decompression; larger ones are 413.",
    )
    wait_seconds: float = Field(
        20.0,
        ge=0,
        allow_inf_nan=False,
        description="Seconds that a request waits for its answer when it does not say `Prefer: wait`; "
        "then it is told where the job is: 201.",
    )
    deadline_seconds: float = Field(
        60.0,
        gt=0,
        allow_inf_nan=False,
        description="Seconds that a request may wait for its answer at most, whatever it prefers.",
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

    def placed(self, home: Path) -> Settings:
        """Fill in where jobs are kept: in a directory, where no address says otherwise."""
        home = home.absolute()
        return self.model_copy(
            update={
                "data_dir": home,
                "database_url": self.database_url or f"sqlite:///{home}/jobs.sqlite",
                "store_url": self.store_url or (home / "store").as_uri(),
            }
        )

    def environment(self) -> dict[str, str]:
        """Write the settings as the variables that they are read from, for a process of ours."""
        return {
            f"TAPELINE_{name.upper()}": _text(value)
            for name, value in self.model_dump().items()
            if value is not None
        }


def _text(value: Any) -> str:
    return ",".join(value) if isinstance(value, tuple) else str(value)
