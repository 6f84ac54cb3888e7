"""The JSON answers of the service, as pydantic models, for the OpenAPI document.

Answers are written by :mod:`service.render` straight from the results' arrays,
without passing through these models: a million rows would take seconds. The
tests read real answers back through them.
"""

from service.answers.base import Link
from service.answers.examples import ExampleAnswer, ExampleList, ExampleParameters, ExampleSummary
from service.answers.jobs import JobList, JobStatus, StatusInfo
from service.answers.ogc import (
    Conformance,
    InputDescription,
    OutputDescription,
    ProcessDescription,
    ProcessList,
    ProcessSummary,
    ResultDocument,
)
from service.answers.operations import ErrorItem, Health, Landing, ProblemDocument, Readiness
from service.answers.partition import PartitionAnswer
from service.answers.reconstruction import DiagnosisAnswer, PcaAnswer, ReconstructAnswer, SkeletonAnswer
from service.answers.surface import ContoursAnswer, SliceAnswer, SurfaceAnswer

__all__ = [
    "Conformance",
    "ContoursAnswer",
    "DiagnosisAnswer",
    "ErrorItem",
    "ExampleAnswer",
    "ExampleList",
    "ExampleParameters",
    "ExampleSummary",
    "Health",
    "InputDescription",
    "JobList",
    "JobStatus",
    "Landing",
    "Link",
    "OutputDescription",
    "PartitionAnswer",
    "PcaAnswer",
    "ProblemDocument",
    "ProcessDescription",
    "ProcessList",
    "ProcessSummary",
    "Readiness",
    "ReconstructAnswer",
    "ResultDocument",
    "SkeletonAnswer",
    "SliceAnswer",
    "StatusInfo",
    "SurfaceAnswer",
]
