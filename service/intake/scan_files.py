"""Files of scans: range grids with the poses that lie beside them, and meshes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import PurePath
from typing import Any

from core.surface.results import Mesh, Pose, RangeImage
from service.intake import media
from service.intake.compression import decompress
from service.intake.errors import ErrorItem, IntakeError, refuse
from service.intake.json import load_json
from service.intake.meshes import decode_mesh
from service.intake.range_ply import decode_conf, decode_range_ply, is_range_ply
from service.intake.scans import size_of
from service.intake.submission import Limits

__all__ = ["ScanFile", "decode_scan", "decode_scans"]

Document = dict[str, Any]
Read = Callable[[bytes, int], Mesh | RangeImage]


@dataclass(frozen=True, slots=True)
class ScanFile:
    """A file as it came: its name without folders, its content, and its media type where that is known."""

    name: str
    content: bytes
    media_type: str = ""


def decode_scan(content: bytes, media_type: str, limits: Limits) -> Document:
    """Read the one scan that is a whole body, in place."""
    return _collected([_READERS[media_type](content, limits.max_points)])


def decode_scans(files: Sequence[ScanFile], limits: Limits) -> Document:
    """Read files that belong together: range grids and meshes, and ``.conf`` files with their poses.

    A JSON file comes alone: it holds what a JSON body does.

    Parameters
    ----------
    files : sequence of ScanFile
        Of which kind each one is its ending tells, or its media type.
    limits : Limits
        For all of them together.

    Returns
    -------
    dict
        ``meshes`` and ``range_images``.

    Raises
    ------
    IntakeError
        As the readers do, with the number of the file as its place; 415 for other files; 422 for a range
        grid that the ``.conf`` files do not name.
    """
    kinds = [_kind(file, k) for k, file in enumerate(files)]
    if len(files) == 1 and kinds[0][0] == media.JSON:
        return _json(files[0], kinds[0][1], limits)
    poses: dict[str, Pose] = {}
    scans: list[tuple[int, str, bytes]] = []
    left = limits.max_bytes
    for k, (file, (kind, encoding)) in enumerate(zip(files, kinds, strict=True)):
        content = _in_file(k, file.name, partial(decompress, file.content, encoding, left))
        left -= len(content)
        if kind == media.CONF:
            poses |= _in_file(k, file.name, partial(decode_conf, content))
        elif kind == media.JSON:
            raise refuse("invalid-input", "a JSON file comes alone", ("body", "file", k), "too_many_files")
        else:
            scans.append((k, kind, content))
    posed = any(kind == media.CONF for kind, _ in kinds)
    return _collected(_read(files, scans, poses if posed else None, limits.max_points))


def _read(
    files: Sequence[ScanFile],
    scans: Iterable[tuple[int, str, bytes]],
    poses: Mapping[str, Pose] | None,
    left: int,
) -> list[Mesh | RangeImage]:
    """Read scans one after the other, and put them where they stand."""
    found: list[Mesh | RangeImage] = []
    for k, kind, content in scans:
        one = _in_file(k, files[k].name, partial(_READERS[kind], content, left))
        left -= _size(one)
        found.append(one if poses is None else _placed(one, poses.get(_plain(files[k].name)), k))
    return found


def _json(file: ScanFile, encoding: str | None, limits: Limits) -> Document:
    document = load_json(decompress(file.content, encoding, limits.max_bytes))
    if not isinstance(document, dict):
        raise refuse("invalid-input", "the file does not hold a JSON object", ("body",), "model_type")
    return document


def _kind(file: ScanFile, number: int) -> tuple[str, str | None]:
    """Media type and content encoding of a file, by its ending or its media type."""
    named, encoding = media.media_type_of_name(file.name)
    known = {*_READERS, media.CONF, media.JSON}
    kind = named if named in known else file.media_type
    if kind not in known:
        detail = "a scan has a name that ends in .ply, .stl, .obj or .conf, or in .json (also with .gz)"
        raise refuse("unsupported-media-type", detail, ("body", "file", number))
    return kind, encoding


def _plain(name: str) -> str:
    """Return the name by which a ``.conf`` file knows a scan: without folders and compression."""
    plain = PurePath(name).name
    return plain.removesuffix(".gz").removesuffix(".zst")


def _in_file(number: int, name: str, read: Callable[[], Any]) -> Any:
    """Read a file; what is wrong in it is told with its number and its name."""
    try:
        return read()
    except IntakeError as error:
        message = f"{name[:80]}: {error.detail}" if name else error.detail
        items = [
            ErrorItem(loc=["body", "file", number, *_within(item["loc"])], msg=item["msg"], type=item["type"])
            for item in error.errors
        ] or [ErrorItem(loc=["body", "file", number], msg=error.detail, type=error.kind.replace("-", "_"))]
        raise IntakeError(error.status, error.kind, error.title, message, items) from None


def _within(loc: Sequence[str | int]) -> list[str | int]:
    """Return where in a file something is: places by number, such as the line of a ``.conf`` file."""
    return [part for part in loc if isinstance(part, int)]


def _placed(one: Mesh | RangeImage, pose: Pose | None, number: int) -> Mesh | RangeImage:
    """Put a scan where it stands; a mesh that is not named stands in place already."""
    if isinstance(one, Mesh):
        moved = None if pose is None else one.vertices @ pose.rotation.T + pose.translation
        return one if moved is None else replace(one, vertices=moved)
    if pose is None:
        detail = "the .conf file names no scan of this name"
        raise refuse("invalid-input", detail, ("body", "file", number), "no_pose")
    return replace(one, pose=pose)


def _size(one: Mesh | RangeImage) -> int:
    if isinstance(one, Mesh):
        return max(len(one.vertices), len(one.faces) // 2)
    return size_of({"range_images": [one]})


def _collected(scans: Iterable[Mesh | RangeImage]) -> Document:
    """Return the members of a document."""
    members: Document = {}
    for one in scans:
        members.setdefault("meshes" if isinstance(one, Mesh) else "range_images", []).append(one)
    return members


def _ply(content: bytes, max_points: int) -> Mesh | RangeImage:
    if is_range_ply(content):
        return decode_range_ply(content, max_points=max_points)
    return decode_mesh(content, "ply", max_points)


def _stl(content: bytes, max_points: int) -> Mesh:
    return decode_mesh(content, "stl", max_points)


def _obj(content: bytes, max_points: int) -> Mesh:
    return decode_mesh(content, "obj", max_points)


_READERS: dict[str, Read] = {media.PLY: _ply, media.STL: _stl, media.OBJ: _obj}
