"""A process for the tests: as slow, deadly or defective as its parameters say."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from core.errors import DegenerateInput, InvalidParameter, InvalidPoints
from core.progress import Progress
from core.results import Partition
from service.answers import PartitionAnswer
from service.processes import PROCESSES, Process


class TrialParameters(BaseModel):
    """What shall happen."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    sign: str | None = Field(None, description="File to write the number of the process to.")
    seconds: float = Field(0.0, ge=0, description="How long to compute.")
    megabytes: int = Field(0, ge=0, description="How much memory to fill.")
    outcome: Literal["result", "death", "defect", "memory", "degenerate", "points", "parameter"] = Field(
        "result", description="What comes of it."
    )


def trial(
    points: NDArray[np.float64], parameters: TrialParameters, *, progress: Progress | None = None
) -> Partition:
    """Put all points in no component."""
    if parameters.sign:
        Path(parameters.sign).write_text(str(os.getpid()))
    held = np.ones((parameters.megabytes, 131_072))
    begin = time.monotonic()
    while (passed := time.monotonic() - begin) < parameters.seconds:
        if progress is not None:
            progress(passed / parameters.seconds, f"second {passed:.1f} of {parameters.seconds}")
    _FATES[parameters.outcome]()
    del held
    return Partition(1.0, "given", np.full(len(points), -1), ())


def _raise(error: Exception) -> Any:
    raise error


_FATES: dict[str, Any] = {
    "result": lambda: None,
    "death": lambda: os.kill(os.getpid(), 9),
    "defect": lambda: _raise(LookupError("secret of the house")),
    "memory": lambda: _raise(MemoryError()),
    "degenerate": lambda: _raise(DegenerateInput("all points are the same; send others", ("points",))),
    "points": lambda: _raise(InvalidPoints("this point is too far off", ("points", 1, 0))),
    "parameter": lambda: _raise(InvalidParameter("seconds contradict the data", ("parameters", "seconds"))),
}

TRIAL = Process(
    id="trial",
    path="/trial",
    title="Try what may happen",
    description="For tests.",
    parameters=TrialParameters,
    answer=PartitionAnswer,
    function="rows:trial",
    forms=("json", "csv"),
)

ALONE = (TRIAL,)
ALL = (TRIAL, *PROCESSES)
SOME = (TRIAL, *(row for row in PROCESSES if row.id in {"partition", "reconstruct-pca"}))
SCANS = tuple(row for row in PROCESSES if row.id == "reconstruct-surface")
