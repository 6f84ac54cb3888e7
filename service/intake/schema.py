"""The one declaration of what a body may hold: how it is checked, and how OpenAPI describes it."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, create_model

from service.intake.rows import Rows
from service.intake.scans import ScanMembers

__all__ = ["Points", "Takes", "submission_model"]

Takes = Literal["points", "scans"]
"""What a process works on: a point cloud, or scans of an object (`core.surface.results.Scans`)."""

Points = Annotated[
    NDArray[np.float64],
    Rows(2, 3),
    Field(
        description="The samples, one row a point: [x, y] or [x, y, z]; all rows of one length, all finite."
    ),
]


class PointMembers(BaseModel):
    """What a body holds besides parameters where a process takes a point cloud."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, arbitrary_types_allowed=True)

    points: Points


_MEMBERS: dict[Takes, type[BaseModel]] = {"points": PointMembers, "scans": ScanMembers}


@lru_cache(maxsize=64)
def submission_model(
    parameters_model: type[BaseModel], include_allowed: frozenset[str], takes: Takes = "points"
) -> type[BaseModel]:
    """Make the model of a body: ``points`` or scans, ``parameters`` and ``include``.

    The same model checks every media type and describes the JSON one in the
    OpenAPI document; its name is that of the parameters with ``Submission``.
    """
    names = tuple(sorted(include_allowed))
    # list[Literal[()]] is no type: where nothing can be asked for, the list must be empty
    include: Any = list[Literal[names]] if names else Annotated[list[str], Field(max_length=0)]  # type: ignore[valid-type] # the names are data
    return create_model(
        parameters_model.__name__.removesuffix("Parameters") + "Submission",
        __base__=_MEMBERS[takes],
        __doc__=None,
        parameters=(parameters_model, Field(default_factory=parameters_model)),
        include=(
            Annotated[include, Field(fail_fast=True)],
            Field(default_factory=list, description="Extra parts that the answer shall contain."),
        ),
    )
