"""What all answers are made of."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

__all__ = ["Answer", "Coordinates", "Frame", "Link", "Pair", "Vector", "Warn"]


class Answer(BaseModel):
    """A JSON object with exactly these members."""

    model_config = ConfigDict(extra="forbid")


Coordinates = Annotated[list[float], Field(min_length=2, max_length=3, description="x, y and, in 3D, z.")]
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]
Pair = Annotated[list[int], Field(min_length=2, max_length=2)]


class Warn(Answer):
    """Something that the caller should know."""

    code: str = Field(description="Stable name, for programs.")
    message: str
    location: Coordinates | None = None


class Frame(Answer):
    """Right-handed orthonormal frame of a component (§3.1)."""

    component: int
    origin: Vector = Field(description="Centre of gravity.")
    axes: Annotated[list[Vector], Field(min_length=3, max_length=3)] = Field(
        description="Unit vectors by decreasing variance; the last is the normal of the best plane."
    )
    planarity: float = Field(description="Between 0 (no plane) and 1 (exactly planar).")


class Link(Answer):
    """A link (RFC 8288)."""

    href: str
    rel: str
    type: str
    title: str | None = None
