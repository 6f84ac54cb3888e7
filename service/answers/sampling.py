"""What the data say of themselves, as answers have it."""

from __future__ import annotations

from pydantic import Field

from service.answers.base import Answer, Coordinates

__all__ = ["Sampling"]


class Violation(Answer):
    """A place where the sample is not Nyquist-compliant (§1)."""

    location: Coordinates
    gap_sigmas: float = Field(description="Size of the detail there, in units of sigma.")
    reason: str = Field(description="What is wrong.")
    kind: str = Field(description="Stable name, for programs.")
    advice: str = Field(description="What to do about it.")


class Nyquist(Answer):
    """Whether the noise is below half of the smallest detail, and by what margin."""

    compliant: bool
    margin_sigmas: float | None = Field(
        description="Smallest distance between branches that are not neighbours along a curve, in units of "
        "sigma; null when none come near."
    )
    margin_location: Coordinates | None = Field(description="Where that is.")
    violations: list[Violation]


class SigmaAlong(Answer):
    """Noise that varies along a curve."""

    curve: int
    locations: list[Coordinates]
    sigma: list[float] = Field(description="Standard deviation of the noise at each of these places.")


class CurveGap(Answer):
    """The longest stretch of a curve without a sample."""

    location: Coordinates = Field(description="Its middle.")
    curve: int
    length: float
    spacings: float = Field(description="Its length, in mean distances between samples.")
    expected: float = Field(
        description="What the longest of as many independent samples would exceed in one set of a hundred."
    )


class ComponentSampling(Answer):
    """What the samples of one component say of themselves."""

    label: int
    size: int
    sigma: float
    sigma_error: float | None
    density: float


class Sampling(Answer):
    """What the data say of themselves."""

    sigma: float = Field(description="Standard deviation of the noise normal to the curve.")
    sigma_error: float | None = Field(description="Standard error of sigma.")
    density: float = Field(description="Samples per unit of length.")
    epsilon: float = Field(description="Largest hop between extended neighbours.")
    nyquist: Nyquist
    sigma_along: list[SigmaAlong] = Field(
        description="An entry for each curve along which the noise varies significantly."
    )
    largest_gap: CurveGap | None
    components: list[ComponentSampling]
