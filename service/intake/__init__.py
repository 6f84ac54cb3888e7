"""Bodies of requests to arrays and models: one decoder a media type.

>>> limits = Limits(max_points=1000, max_bytes=100_000)
>>> from core.parameters import PcaParameters
>>> body = b'{"points": [[0, 0], [1, 0.5]], "parameters": {"radius": 2}}'
>>> submission = decode(body, "application/json", None, {}, PcaParameters, frozenset(), limits)
>>> submission.points.shape, submission.parameters.radius
((2, 2), 2.0)
"""

from service.intake.compression import decompress
from service.intake.decoders import MEDIA_TYPES, decode, enveloped
from service.intake.envelope import Reply, execute_model
from service.intake.errors import ErrorItem, IntakeError, refuse
from service.intake.json import load_json, paused_collector
from service.intake.media import media_type_of_name
from service.intake.query import Query
from service.intake.scan_files import ScanFile, decode_scans
from service.intake.schema import Points, Takes, submission_model
from service.intake.submission import Limits, Submission, check_document

__all__ = [
    "MEDIA_TYPES",
    "ErrorItem",
    "IntakeError",
    "Limits",
    "Points",
    "Query",
    "Reply",
    "ScanFile",
    "Submission",
    "Takes",
    "check_document",
    "decode",
    "decode_scans",
    "decompress",
    "enveloped",
    "execute_model",
    "load_json",
    "media_type_of_name",
    "paused_collector",
    "refuse",
    "submission_model",
]
