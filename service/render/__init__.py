"""Results to bytes: one encoder a form.

A new type of result is registered where its form is made:
``document.register`` (JSON), ``feature_collection.register`` (GeoJSON),
``table.register`` (CSV), ``report.register`` (plain text) and ``scene.register``
(both pictures).
"""

from service.render.csv import points_table, table
from service.render.documents import document, dump_json
from service.render.encoders import encode
from service.render.forms import FORMS, decided, negotiate
from service.render.geojson import feature_collection
from service.render.pictures import scene
from service.render.replies import Settled, enclose, settle
from service.render.report import report

__all__ = [
    "FORMS",
    "Settled",
    "decided",
    "document",
    "dump_json",
    "enclose",
    "encode",
    "feature_collection",
    "negotiate",
    "points_table",
    "report",
    "scene",
    "settle",
    "table",
]
