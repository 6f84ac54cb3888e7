"""Parameters of the way from range images to one closed surface, declared once."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from core.parameters import Length

__all__ = ["MAX_LEVELS", "ContourParameters", "SliceParameters", "SurfaceParameters"]

MAX_LEVELS = 10_000

Coordinate = Annotated[float, Field(allow_inf_nan=False)]


class SliceParameters(BaseModel):
    """Where the planes lie that cut the meshes; at most one of ``levels``, ``spacing`` and ``heights``."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    axis: tuple[Coordinate, Coordinate, Coordinate] = Field(
        (0.0, 0.0, 1.0),
        strict=False,
        description="Direction across the planes; its length does not matter.",
    )
    levels: int | None = Field(
        None,
        ge=1,
        le=MAX_LEVELS,
        description="Number of planes, equally spaced over the extent along the axis.",
    )
    spacing: Length | None = Field(
        None,
        description="Distance between planes, in input units. Null: the typical distance between samples, "
        "which is half the finest wavelength that they carry (Nyquist), kept to 100 to 400 planes.",
    )
    heights: tuple[Coordinate, ...] | None = Field(
        None,
        strict=False,
        min_length=1,
        max_length=MAX_LEVELS,
        description="Heights of the planes along the axis, in input units.",
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if sum(one is not None for one in (self.levels, self.spacing, self.heights)) > 1:
            raise ValueError("give at most one of levels, spacing and heights")
        if not any(self.axis):
            raise ValueError("the axis must not be zero")
        return self


class ContourParameters(SliceParameters):
    """How slices become closed contours (§5.1.1)."""

    complete: bool = Field(
        True,
        description="Complete levels whose samples leave gaps, or are missing, from their neighbours'.",
    )


class SurfaceParameters(ContourParameters):
    """How contours become one closed surface (§5.1.1)."""

    similarity: float = Field(
        0.0,
        ge=0,
        le=1,
        description="Contours of neighbouring levels are connected when they overlap by at least this share "
        "of the smaller one's area. 0: whenever they overlap.",
    )
    method: Literal["slabs", "distance"] | None = Field(
        None,
        description="'slabs' (null means the same): faces span from contour to contour, and signed distances "
        "step in should they fail, which the report tells; 'distance': signed distances are interpolated "
        "between the levels: rounded, and never finer than a raster of 256 pixels.",
    )
