"""The answers of the reconstructions and of the diagnosis."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from service.answers.base import Answer, Frame, Warn
from service.answers.curves import Crossing, Curve, PcaStages
from service.answers.sampling import Sampling
from service.answers.skeleton import Containment, Graph, MultiPolygon, SkeletonStages

__all__ = ["DiagnosisAnswer", "PcaAnswer", "ReconstructAnswer", "SkeletonAnswer"]

Method = Literal["pca", "skeleton"]


class Evidence(Answer):
    """What speaks for and against one method's curves of a component."""

    component: int
    method: Method
    reason: str = Field(description="Why they were chosen, or not.")
    curves: int = Field(description="How many.")
    closed: int = Field(description="How many of them are closed.")
    crossings: int
    sigma: float = Field(description="Noise about them.")
    explained: float = Field(description="Share of the component's samples that they explain, 0 to 1.")
    largest_gap: float = Field(
        description="Longest stretch of curve without a sample, in mean distances between samples."
    )
    nats: float = Field(
        description="How much longer the samples' description by them is than by the chosen ones, at least 0."
    )


class _Reconstruction(Answer):
    """Curves, and all that is known of how good they are, by whatever method."""

    method: str
    reason: str
    curves: list[Curve]
    crossings: list[Crossing]
    outliers: list[int] = Field(description="Indices of the points that no curve explains.")
    sampling: Sampling
    frames: list[Frame]
    warnings: list[Warn]


class PcaAnswer(_Reconstruction):
    """Curves, and all that is known of how good they are."""

    method: Literal["pca"]
    stages: PcaStages | None = Field(None, description="Only when `include` names it.")


class SkeletonAnswer(_Reconstruction):
    """Curves, the tape polygon and the skeleton that they were read from."""

    method: Literal["skeleton"]
    tape: MultiPolygon = Field(description="The tape polygon T (§4.4).")
    tape_components: list[int] = Field(description="For each polygon of the tape: its component.")
    containment: Containment | None = Field(
        description="Null without a tape: sparse or collinear samples are joined to their neighbours instead."
    )
    graph: Graph
    stages: SkeletonStages | None = Field(None, description="Only when `include` names it.")


class ReconstructAnswer(_Reconstruction):
    """Curves by the method that the data call for, and why it was that one."""

    method: Method = Field(description="Whose curves most samples lie on; `decisions` has each component's.")
    reason: str = Field(description="Why it was chosen.")
    decisions: list[Evidence] = Field(description="What each component got, and why.")
    alternatives: list[Evidence] = Field(description="What each component would have got otherwise.")
    tape: MultiPolygon | None = Field(
        description="The tape polygon T (§4.4) of the components that are by the skeleton; null without any."
    )
    tape_components: list[int] | None = Field(description="For each polygon of the tape: its component.")
    containment: Containment | None
    graph: Graph | None
    stages: PcaStages | SkeletonStages | None = Field(
        None, description="Those of `method`; only when `include` names it."
    )


class DiagnosisAnswer(Answer):
    """What a point set is fit for."""

    verdict: str = Field(description="Whether the samples are good enough, in one sentence.")
    method: Method = Field(description="The method that the data call for.")
    reason: str = Field(description="Why that one.")
    curves: int = Field(description="How many would be found.")
    closed: int = Field(description="How many of them are closed.")
    crossings: int
    outliers: list[int] = Field(description="Indices of the points that no curve explains.")
    sampling: Sampling
    frames: list[Frame]
    decisions: list[Evidence] = Field(description="What each component calls for, and why.")
    alternatives: list[Evidence] = Field(description="What it would get otherwise.")
    warnings: list[Warn]
