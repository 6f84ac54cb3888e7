"""Results to bytes: one encoder a form.

A new type of result is registered where its form is made:
``document.register`` (JSON), ``feature_collection.register`` (GeoJSON),
``table.register`` (CSV), ``report.register`` (plain text) and ``scene.register``
(both pictures), ``lines.register`` (DXF), ``mesh_of.register`` (all forms of meshes).
"""

from service.render import surface_documents  # noqa: F401 # registers them
from service.render.csv import points_table, table
from service.render.documents import document, dump_json
from service.render.dxf import lines
from service.render.encoders import encode
from service.render.forms import FORMS, decided, negotiate
from service.render.geojson import feature_collection
from service.render.meshes import mesh_of
from service.render.pictures import scene
from service.render.replies import Settled, enclose, settle
from service.render.report import report
from service.render.shaded import shaded  # with it, the pictures of surfaces are registered
from service.render.stacks import stack_of  # with it, all forms of stacks are registered

__all__ = [
    "FORMS",
    "Settled",
    "decided",
    "document",
    "dump_json",
    "enclose",
    "encode",
    "feature_collection",
    "lines",
    "mesh_of",
    "negotiate",
    "points_table",
    "report",
    "scene",
    "settle",
    "shaded",
    "stack_of",
    "table",
]
