"""Scans of an object in JSON bodies: meshes, range images, slices, contours, to what the core works on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    ValidationError,
    ValidatorFunctionWrapHandler,
    model_validator,
)
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, core_schema

from core.results import Curve
from core.surface.results import ContourLevel, Mesh, Pose, RangeImage, Scans, Slice
from service.intake.errors import MAX_LISTED
from service.intake.range_ply import HOLES
from service.intake.rows import Grid, Rows, located

__all__ = ["KINDS", "ScanMembers", "size_of"]

Floats = NDArray[np.float64]

KINDS = ("meshes", "range_images", "slices", "contours")
"""What a body may hold: one of these, or meshes and range images together."""

_MOST = 10_000  # meshes, images or levels: as many as there may be planes
_MEMBERS = 8  # of an object: more than any has, and few enough to complain about one by one
_SQUARE = 1e-4  # by how much a rotation's columns may fail to be orthonormal, as float32 ones do

Real = Annotated[float, Field(allow_inf_nan=False)]
Vector = Annotated[list[Real], Field(min_length=3, max_length=3)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, arbitrary_types_allowed=True)

    @model_validator(mode="before")
    @classmethod
    def _few(cls, value: object) -> object:
        """Refuse an object of a million members with one error."""
        if isinstance(value, dict) and len(value) > _MEMBERS:
            raise PydanticCustomError("extra_forbidden", "this object has too many members")
        return value


class MeshInput(_Part):
    """A triangle mesh."""

    vertices: Annotated[Floats, Rows(3, 3)] = Field(description="[x, y, z], one row a vertex.")
    faces: Annotated[NDArray[np.int64], Rows(3, 3, whole=True)] = Field(
        description="Indices of three vertices, counter-clockwise seen from outside; the first vertex is 0."
    )

    @model_validator(mode="after")
    def _indexed(self) -> Self:
        wrong = np.argwhere(self.faces >= len(self.vertices))[:MAX_LISTED].tolist()
        if wrong:
            error = PydanticCustomError("index_out_of_range", "there is no vertex of this index")
            raise located(InitErrorDetails(type=error, loc=("faces", *place), input=None) for place in wrong)
        return self

    def made(self) -> Mesh:
        """Return what the core takes."""
        return Mesh(self.vertices, self.faces)


class PoseInput(_Part):
    """A rigid motion: a point p of the scan lies at R p + t."""

    rotation: Annotated[list[Vector], Field(min_length=3, max_length=3)] | None = Field(
        None, description="R as three rows. Null: no rotation, or the quaternion's."
    )
    quaternion: Annotated[list[Real], Field(min_length=4, max_length=4)] | None = Field(
        None,
        description="R as [x, y, z, w], of any length but zero. Stanford `.conf` files hold its conjugate.",
    )
    translation: Vector = Field([0.0, 0.0, 0.0], description="t.")

    @model_validator(mode="after")
    def _rigid(self) -> Self:
        if self.rotation is not None and self.quaternion is not None:
            raise PydanticCustomError("two_rotations", "give rotation or quaternion, not both")
        if self.rotation is not None and not _is_rotation(np.array(self.rotation, np.float64)):
            raise _wrong("rotation", "not_a_rotation", "the rows are not those of a rotation")
        if self.quaternion is not None and not any(self.quaternion):
            raise _wrong("quaternion", "not_a_rotation", "this quaternion is zero")
        return self

    def made(self) -> Pose:
        """Return what the core takes."""
        rotation = np.eye(3) if self.rotation is None else np.array(self.rotation, np.float64)
        if self.quaternion is not None:
            rotation = _rotation(np.array(self.quaternion, np.float64))
        return Pose(rotation, np.array(self.translation, np.float64))


def _is_rotation(rows: Floats) -> bool:
    if np.abs(rows).max() > 2.0:
        return False
    square = bool(np.abs(rows @ rows.T - np.eye(3)).max() <= _SQUARE)
    return square and float(np.linalg.det(rows)) > 0.0


def _rotation(quaternion: Floats) -> Floats:
    """Return the rotation of a quaternion [x, y, z, w] of any length."""
    quaternion = quaternion / np.abs(quaternion).max()
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew, np.float64)


def _wrong(member: str, code: Any, message: Any) -> Exception:
    error = PydanticCustomError(code, message)
    return located([InitErrorDetails(type=error, loc=(member,), input=None)])


class RangeImageInput(_Part):
    """A range image: what each pixel of a scanner's grid has seen."""

    points: Annotated[Floats, Grid()] = Field(
        description="Rows of pixels [x, y, z], all of one length; a hole is null or [null, null, null]. Rows "
        "and columns turn so that dP/dcolumn x dP/drow points out of the object, towards the scanner."
    )
    pose: PoseInput | None = Field(None, description="Where the scan stands. Null: in place already.")

    def made(self) -> RangeImage:
        """Return what the core takes."""
        return RangeImage(self.points, None if self.pose is None else self.pose.made())


class SliceInput(_Part):
    """Samples of the contours at one level."""

    height: Real = Field(description="Along the axis.")
    points: Annotated[Floats, Rows(2, 3, least=0)] = Field(
        description="2D in the plane's axes, which are x and y for the default axis, or 3D in place; none "
        "for a level that is missing."
    )

    def made(self) -> Slice:
        """Return what the core takes."""
        return Slice(self.height, self.points)


class CurveInput(_Part):
    """A contour."""

    vertices: Annotated[Floats, Rows(2, 3)] = Field(
        description="2D in the plane's axes or 3D in place; the first vertex is not repeated."
    )
    closed: bool = True

    def made(self) -> Curve:
        """Return what the core takes; a first vertex that is repeated at the end is left out."""
        vertices = self.vertices
        if self.closed and len(vertices) > 1 and np.array_equal(vertices[0], vertices[-1]):
            vertices = vertices[:-1]
        near = np.clip(vertices, -_FAR, _FAR)
        steps = np.diff(near, axis=0, append=near[:1] if self.closed else near[-1:])
        length = float(np.linalg.norm(steps, axis=1).sum())
        return Curve(vertices, self.closed, 0, length, len(vertices), 0.0)


_FAR = 1e150  # what lies further off is refused by the core


class _CurveOrRows:
    """For ``Annotated``: a contour as an object, or its vertices alone."""

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        rows = handler.generate_schema(Annotated[Floats, Rows(2, 3)])
        either = core_schema.tagged_union_schema(
            {"rows": rows, "curve": handler.generate_schema(CurveInput)},
            discriminator=lambda value: "rows" if isinstance(value, list) else "curve",
        )
        return core_schema.no_info_wrap_validator_function(_curve, either)


def _curve(value: object, handler: ValidatorFunctionWrapHandler) -> Curve:
    try:
        found = handler(value)
    except ValidationError as error:  # without the tag, which is none of the client's
        items = error.errors(include_url=False, include_input=False)
        raise located(_untagged(item) for item in items) from None
    return (found if isinstance(found, CurveInput) else CurveInput.model_construct(vertices=found)).made()


def _untagged(item: Any) -> InitErrorDetails:
    code: Any = item["type"]
    message = item["msg"].replace("{", "(").replace("}", ")")
    return InitErrorDetails(type=PydanticCustomError(code, message), loc=item["loc"][1:], input=None)


class ContourInput(_Part):
    """The contours at one level."""

    height: Real = Field(description="Along the axis.")
    curves: list[Annotated[Curve, _CurveOrRows]] = Field(
        fail_fast=True,
        description="Closed curves, nested ones for holes and islands: their vertices alone, or objects.",
    )

    def made(self) -> ContourLevel:
        """Return what the core takes."""
        curves = tuple(replace(one, component=k) for k, one in enumerate(self.curves))
        return ContourLevel(self.height, curves)


@dataclass(frozen=True, slots=True)
class _Made:
    """For ``Annotated``: what the core takes, checked and described as a model of the body's."""

    model: type[_Part]
    kind: type

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_wrap_validator_function(self._make, handler.generate_schema(self.model))

    def _make(self, value: object, handler: Callable[[object], Any]) -> Any:
        return value if isinstance(value, self.kind) else handler(value).made()  # files bring what is made


def _some(description: str) -> Any:
    return Field(default_factory=list, max_length=_MOST, fail_fast=True, description=description)


class ScanMembers(BaseModel):
    """What a body holds besides parameters where a process takes scans."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, arbitrary_types_allowed=True)

    meshes: list[Annotated[Mesh, _Made(MeshInput, Mesh)]] = _some("Triangle meshes, closed or not.")
    range_images: list[Annotated[RangeImage, _Made(RangeImageInput, RangeImage)]] = _some(
        "Range images, registered by their poses; may come together with meshes."
    )
    slices: list[Annotated[Slice, _Made(SliceInput, Slice)]] = _some(
        "Samples of contours level by level, in any order."
    )
    contours: list[Annotated[ContourLevel, _Made(ContourInput, ContourLevel)]] = _some(
        "Contours level by level, in any order; a level without any is empty space."
    )

    def scans(self) -> Scans:
        """Return what the core takes."""
        return Scans(tuple(self.meshes), tuple(self.range_images), tuple(self.slices), tuple(self.contours))


# --- how much there is, before it is checked ---------------------------------------------------------


def size_of(document: dict[str, Any]) -> int:
    """Count the points of a document that may hold anything: vertices, pixels and samples.

    Faces count half, and pixels that hold no point a quarter, where they are more.
    """
    return sum(
        _SIZES[name](one) for name in KINDS if isinstance(document.get(name), list) for one in document[name]
    )


def _of_mesh(one: Any) -> int:
    return max(_length(_member(one, "vertices")), _length(_member(one, "faces")) // 2)


def _of_image(one: Any) -> int:
    rows = _member(one, "points")
    if isinstance(rows, np.ndarray):
        return max(int(np.isfinite(rows[..., 0]).sum()) if rows.ndim else 0, rows.size // 3 // HOLES)
    if not isinstance(rows, list):
        return 0
    seen = sum(len(row) - row.count(None) for row in rows if isinstance(row, list))
    return max(seen, sum(map(_length, rows)) // HOLES)


def _of_slice(one: Any) -> int:
    return 1 + _length(_member(one, "points"))


def _of_contour(one: Any) -> int:
    curves = _member(one, "curves")
    if not isinstance(curves, list | tuple):
        return 1
    return 1 + sum(
        1 + _length(each if isinstance(each, list) else _member(each, "vertices")) for each in curves
    )


_SIZES: dict[str, Callable[[Any], int]] = {
    "meshes": _of_mesh,
    "range_images": _of_image,
    "slices": _of_slice,
    "contours": _of_contour,
}


def _member(one: Any, name: str) -> Any:
    return one.get(name) if isinstance(one, dict) else getattr(one, name, None)


def _length(value: Any) -> int:
    return len(value) if isinstance(value, list | np.ndarray) else 0
