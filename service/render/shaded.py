"""Pictures of surfaces: shaded, without perspective, seen from the front right and above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.surface.axis import axis_frame
from core.surface.results import Mesh, Surface
from service.render.meshes import normals_of
from service.render.pen import Pen
from service.render.pictures import scene
from service.render.plane import three_quarter
from service.render.scenes import Picture, Scene

__all__ = ["brightness", "shaded"]

Floats = NDArray[np.float64]

_PIXELS = 960  # along the longer side: as many as a PNG has
_FINER = 2  # pixels are means of so many by so many
_LIGHTS = ((-0.45, 0.50, 0.74), 0.75), ((0.85, 0.10, 0.35), 0.25)  # right, up, to the eye; strength
_AMBIENT = 0.16
_ROUNDING = 1e-6  # of a pixel
_CREASE = np.cos(np.radians(30.0))  # faces that turn further from their neighbours' mean have edges
_OUTSIDE = ("#16273B", "#7FA3C4", "#FBFCFD")  # dark, middle and bright
_TONES = 256
_INSIDE = ("#3B1C0C", "#D9905F", "#FFF6EF")  # of what is seen from behind, through a hole


@scene.register
def _(result: Surface, points: Floats | None = None) -> Scene:  # noqa: ARG001 # the mesh says it all
    """Show the mesh; its inside, should it be seen through a hole, in another colour."""
    report = result.report
    title = (
        f"{report.components} component{'' if report.components == 1 else 's'}, genus {report.genus}, "
        f"{'closed' if report.closed else 'not closed'}, {len(result.mesh.faces)} faces"
    )
    unit, picture = shaded(result.mesh, result.axis)
    return Scene(title, pictures=() if picture is None else (picture,), unit=unit, bare=True)


def shaded(mesh: Mesh, axis: Floats, pixels: int = _PIXELS) -> tuple[float, Picture | None]:
    """Draw a mesh with light from above, upright along an axis.

    Parameters
    ----------
    mesh : Mesh
    axis : (3,) array
        What points up.
    pixels : int
        Of the longer side.

    Returns
    -------
    float
        The unit of the picture's coordinates.
    Picture or None
        None when there is nothing to be seen.
    """
    if not len(mesh.faces):
        return 1.0, None
    unit = Pen.of([mesh.vertices]).unit
    look = three_quarter(axis_frame(axis.tolist()).axes)
    low, high, image = brightness(Mesh(mesh.vertices / unit, mesh.faces), look, pixels)
    return unit, Picture(_coloured(image), low, high)


def brightness(
    mesh: Mesh, look: Floats, pixels: int, offsets: Floats | float = 0.0
) -> tuple[Floats, Floats, Floats]:
    """Light a mesh, and tell how bright each point of the picture is.

    Parameters
    ----------
    mesh : Mesh
    look : (3, 3) array
        Rows right, up and towards the eye.
    pixels : int
        Of the longer side.
    offsets : (F,) array, optional
        Added to the brightness of each face, by which one can tell faces apart.

    Returns
    -------
    low, high : (2,) arrays
        Corners of the picture; its middle is that of the mesh's box.
    (H, W) array
        From 0 to 1, negated where the inside is seen, NaN where nothing is; twice as many points as
        pixels each way.
    """
    from service.render.raster import fill  # noqa: PLC0415 # numba, which the web process shall not import

    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    places = (mesh.vertices - (low + high) / 2.0) @ look.T
    low, high = places.min(axis=0), places.max(axis=0)
    scale = _FINER * pixels / (float((high - low)[:2].max()) or 1.0)
    size = np.ceil((high - low)[:2] * scale / _FINER - _ROUNDING)
    columns, rows = (np.maximum(size, 1).astype(int) * _FINER).tolist()
    depth, image = np.full((rows, columns), -np.inf), np.full((rows, columns), np.nan)
    values = _light(mesh, look) + np.reshape(offsets, (-1, 1))
    fill(((places - low) * scale)[mesh.faces], values, depth, image)
    return low[:2], low[:2] + np.array([columns, rows]) / scale, image


def _light(mesh: Mesh, look: Floats) -> Floats:
    """Return the brightness (F, 3) of each corner, 0 to 1: smooth but across creases."""
    flat, smooth = normals_of(mesh)
    flat, corners = flat @ look.T, (smooth @ look.T)[mesh.faces]
    alike = np.einsum("fj,fkj->fk", flat, corners) > _CREASE
    normals = np.where(alike[..., None], corners, flat[:, None])
    normals *= np.where(flat[:, 2] < 0.0, -1.0, 1.0)[:, None, None]  # light falls on the side that is seen
    bright = np.full(normals.shape[:2], _AMBIENT)
    for direction, strength in _LIGHTS:
        bright += strength * np.maximum(normals @ (np.array(direction) / np.linalg.norm(direction)), 0.0)
    result: Floats = np.clip(bright, 1e-3, 1.0)  # not 0, whose sign says nothing
    return result


def _coloured(image: Floats) -> NDArray[np.uint8]:
    """Return the picture (H, W, 4): means of its finer pixels, transparent where nothing is."""
    bright = (np.nan_to_num(np.abs(image)) * (_TONES - 1)).astype(np.int16)
    tone = np.where(np.isnan(image), 0, 1 + bright + np.int16(_TONES) * (image < 0.0))
    fine = _palette()[tone]
    sums = fine.reshape(image.shape[0] // _FINER, _FINER, -1, _FINER, 4).sum(axis=(1, 3))
    share = np.maximum(sums[..., 3:], 1.0)  # of nothing there is no colour
    sums[..., :3] *= 255.0 / share
    sums[..., 3] /= _FINER**2
    pixels: NDArray[np.uint8] = np.round(sums).astype(np.uint8)
    return pixels


def _palette() -> NDArray[np.float32]:
    """Return colours (1 + 2 tones, 4): nothing, and the tones of the outside and of the inside."""
    at = np.linspace(0.0, 1.0, _TONES)
    table = np.zeros((1 + 2 * _TONES, 4), np.float32)
    for first, ramp in ((1, _OUTSIDE), (1 + _TONES, _INSIDE)):
        for k in range(3):
            steps = [int(colour[1 + 2 * k : 3 + 2 * k], 16) for colour in ramp]
            table[first : first + _TONES, k] = np.interp(at, (0.0, 0.5, 1.0), steps)
    table[1:, 3] = 255.0
    return table
