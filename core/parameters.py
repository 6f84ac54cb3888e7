"""Every parameter of the core, declared once: unit, range, default and source.

The models feed validation, the OpenAPI document, the query parameters, the
command line and the docs. ``None`` always means "let the data decide".
Lengths are in the units of the input points.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

__all__ = [
    "CommonParameters",
    "PartitionParameters",
    "PcaParameters",
    "ReconstructParameters",
    "SkeletonParameters",
]

Length = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class _Parameters(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class PartitionParameters(_Parameters):
    """Parameters of the partition into extended neighbours (§3.3)."""

    epsilon: Length | None = Field(
        None,
        description="Largest hop between extended neighbours, in input units (§3.3). "
        "Null: estimated from the density along the curves.",
    )
    min_component_size: int | None = Field(
        None,
        ge=1,
        description="Components with fewer points are labelled -1. Null: grows with ln N.",
    )


class CommonParameters(PartitionParameters):
    """Parameters that every reconstruction method understands."""

    outliers: Literal["auto", "keep", "reject"] = Field(
        "auto",
        description="'auto': samples that the noise does not explain are left out when there are any; "
        "'keep': no sample of a component counts as one; 'reject': strict, at three standard deviations.",
    )
    refine: bool = Field(
        True,
        description="Move the curve to the local regression of its samples, with the curvature bias removed.",
    )
    vertex_spacing: Length | None = Field(
        None,
        description="Distance between neighbouring vertices of the result, in input units. "
        "Null: fine enough that chords deviate by less than the standard error.",
    )
    seed: int = Field(
        0, ge=0, le=2**32 - 1, description="Seed of every random choice; the same seed, the same answer."
    )


class PcaParameters(CommonParameters):
    """Parameters of the PCA march (§4.2)."""

    radius: Length | None = Field(
        None,
        description="Radius of the local balls B(p, r), in input units (§4.2.1). "
        "Null: the first local minimum of the normalised fitting error, per place.",
    )
    step: Length | None = Field(
        None,
        description="Distance d marched from ball to ball, in input units (§4.2.2). "
        "Null: half the local radius.",
    )
    max_uses: int | None = Field(
        None,
        ge=1,
        description="In how many balls a sample may be used (§4.2.2). "
        "Null: samples are owned with a direction, so that crossings are marched straight through.",
    )
    estimator: Literal["pca", "least_squares"] = Field(
        "pca",
        description="Line fit in the first ball: principal axes (§3.1), or least squares in frames "
        "that start turned at random (§3.2).",
    )
    planar: bool | None = Field(
        None,
        description="True: project each component on its best plane (§4.1); false: march in 3D. "
        "Null: project the components that are quasi-planar.",
    )


class SkeletonParameters(CommonParameters):
    """Parameters of the tape polygon and its skeleton (§4.3 - 4.5)."""

    crossings: Literal["through", "split", "waist", "graph"] = Field(
        "through",
        description="How curves are read at a self-intersection (§5.2). 'through': straight on; 'split': "
        "tangent closed curves, of which no two cross; 'waist': one closed curve with wasp waists, which "
        "does not cross itself; 'graph': one curve for each stretch between crossings.",
    )
    f_d: float = Field(
        1.3,
        gt=0,
        le=100,
        description="Typical triangles are those inside f_d times a local ball B(p, r) (§4.4).",
    )
    f_a: float | None = Field(
        None,
        gt=0,
        allow_inf_nan=False,
        description="A triangle is small when its area is at most f_a times the typical one (§4.4). "
        "Null: what the core of the tape has, from noise and density per place.",
    )
    f_l: float | None = Field(
        None,
        gt=0,
        allow_inf_nan=False,
        description="A triangle is small when its longest edge is at most f_l times the typical one (§4.4). "
        "Null: what the core of the tape has, from noise and density per place; longer edges bridge the "
        "gaps that independent samples leave, along the local balls only.",
    )
    resample: Length | None = Field(
        None,
        description="Distance between the samples of the tape's border, in input units (§4.5). Null: a share "
        "of the tape's mean width. It is halved while the skeleton leaves the tape.",
    )
    prune: float | None = Field(
        None,
        ge=0,
        le=100,
        description="Leaves of the skeleton that reach beyond the disc at their fork by less than this "
        "many of its radii are hair (§7). Null: 2.",
    )


class ReconstructParameters(PcaParameters, SkeletonParameters):
    """Parameters of the reconstruction by the method that the data call for: those of both methods."""

    method: Literal["auto", "pca", "skeleton"] = Field(
        "auto",
        description="'auto': each component gets the curves that explain its samples better; 'pca' and "
        "'skeleton': only that method is run.",
    )
