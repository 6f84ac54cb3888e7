"""Results of the core as one file, and back, to the last bit.

The file is an uncompressed zip. ``value.json`` has the structure; the numbers of all arrays of one type
follow one another in one member, ``0.npy``, ``1.npy`` ...: a result may have a hundred thousand arrays
of two numbers. Nothing in it can be executed. On the way back it may name dataclasses and parameter
models, and those of the packages below only.

In ``value.json`` numbers, strings, booleans and null stand for themselves and a list for a tuple; all
else is an object of one entry:

====== ================================= =====================================================
``$``  ``[k, field, field, ...]``        an instance of dataclass ``k`` of ``classes``
``&``  ``[k, {name: value, ...}]``       a pydantic model, ``k`` of ``classes``
``#``  ``[k, offset, order, *shape]``    an array of ``k.npy``, with its order of axes in memory
``.``  ``[k, offset]``                   a numpy scalar of ``k.npy``
``b``  ``[k, offset, size]``             bytes
``g``  ``[k, offset, size]``             a shapely geometry, as well-known binary
``l``  ``[item, ...]``                   a list
``d``  ``[[key, value], ...]``           a dict
``n``  text                              a number that JSON has not: not finite, or beyond 64 bits
====== ================================= =====================================================
"""

from __future__ import annotations

import gc
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from importlib import import_module
from io import BytesIO
from typing import Any
from zipfile import ZipFile, ZipInfo

import numpy as np
import orjson
from numpy.typing import NDArray
from pydantic import BaseModel

__all__ = ["FrozenError", "freeze", "thaw"]

VERSION = 1
DATACLASSES = ("core",)  # packages whose dataclasses may be named
MODELS = ("core", "service")  # those whose pydantic models may be
BYTES = np.dtype(np.uint8)
IN_JSON = frozenset({str, bool, type(None)})


class FrozenError(ValueError):
    """Bytes that are no frozen value, or one of another version of the classes it names."""


def freeze(value: object) -> bytes:
    """Write a value as the content of one file.

    Parameters
    ----------
    value : object
        Frozen dataclasses of the core and parameter models, over numpy arrays and scalars, shapely
        geometries, tuples, lists, dicts, strings, bytes, numbers and None.

    Raises
    ------
    TypeError
        When there is anything else in it.
    """
    freezer = _Freezer()
    with _no_collection():
        structure = {"value": freezer.frozen(value), "version": VERSION, "classes": freezer.classes}
        text = orjson.dumps(structure)
    file = BytesIO()
    with ZipFile(file, "w") as archive:
        archive.writestr(ZipInfo("value.json"), text)
        for k, buffer in enumerate(freezer.buffers):
            with archive.open(ZipInfo(f"{k}.npy"), "w", force_zip64=True) as member:
                np.lib.format.write_array(member, buffer.together(), allow_pickle=False)
    return file.getvalue()


def thaw(content: bytes | memoryview) -> Any:
    """Read a value that :func:`freeze` wrote.

    Parameters
    ----------
    content : bytes-like
        Of the file.

    Returns
    -------
    object
        Equal to what was frozen to the last bit; its arrays can be written to and lie in memory in the
        same order of axes.

    Raises
    ------
    FrozenError
        When it is not the content of such a file, or of another version.
    """
    try:
        with _no_collection():
            return _thawed(content)
    except (FrozenError, MemoryError):
        raise
    except Exception as error:  # a damaged file may lead to any
        raise FrozenError(f"This is no frozen value, or one of another version: {error}") from error


def _thawed(content: bytes | memoryview) -> Any:
    with ZipFile(BytesIO(content)) as archive:
        structure = orjson.loads(archive.read("value.json"))
        if structure["version"] != VERSION:
            raise FrozenError(f"This value was frozen as version {structure['version']}, not {VERSION}.")
        buffers = []
        for k in range(len(archive.namelist()) - 1):
            with archive.open(f"{k}.npy") as member:
                buffers.append(np.lib.format.read_array(member, allow_pickle=False))
    return _Thawer(buffers, structure["classes"]).thawed(structure["value"])


@contextmanager
def _no_collection() -> Iterator[None]:
    """Look for no garbage meanwhile: among 10^5 new objects, none of it, that takes longer than all else."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


class _Buffer:
    """Arrays of one type, one after the other."""

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self.dtype = dtype
        self.arrays: list[NDArray[Any]] = []
        self.size = 0

    def add(self, array: NDArray[Any]) -> int:
        """Append the numbers of an array; return where they begin."""
        start = self.size
        self.arrays.append(array.ravel())
        self.size += array.size
        return start

    def together(self) -> NDArray[Any]:
        """All of them, (size,)."""
        if len(self.arrays) == 1:
            return self.arrays[0]
        return np.concatenate(self.arrays, out=np.empty(self.size, self.dtype))  # keeps the order of bytes


class _Freezer:
    """Turns a value into what JSON has, and collects its arrays and the names of its classes."""

    def __init__(self) -> None:
        self.buffers: list[_Buffer] = []
        self.classes: list[list[Any]] = []
        self._places: dict[np.dtype[Any], int] = {}
        self._known: dict[type, tuple[int, tuple[str, ...]]] = {}
        self._arrays: dict[int, tuple[NDArray[Any], Any]] = {}  # by identity; the array is kept alive
        self._ways: dict[type, Callable[[Any], Any]] = {
            int: self._integer,
            float: _real,
            tuple: self._items,
            list: lambda value: {"l": self._items(value)},
            dict: lambda value: {"d": [self._items(pair) for pair in value.items()]},
            bytes: lambda value: {"b": self._bytes(value)},
            np.ndarray: self._array,
        }

    def frozen(self, value: Any) -> Any:
        """What stands for a value in the JSON text."""
        kind = type(value)
        if kind in IN_JSON:
            return value
        way = self._ways.get(kind)
        if way is None:
            way = self._ways[kind] = self._way_of(kind)
        return way(value)

    def _way_of(self, kind: type) -> Callable[[Any], Any]:
        """How values of a class are frozen that is met for the first time."""
        if is_dataclass(kind):
            names = tuple(each.name for each in fields(kind) if each.init)
            self._known[kind] = self._named(kind, DATACLASSES, names), names
            return self._dataclass
        if issubclass(kind, BaseModel):
            self._known[kind] = self._named(kind, MODELS, ()), ()
            return self._model
        if issubclass(kind, np.generic):
            return self._scalar
        if kind.__module__.partition(".")[0] == "shapely":
            return lambda value: {"g": self._bytes(_shapely().to_wkb(value))}
        raise TypeError(f"{kind.__module__}.{kind.__qualname__} cannot be frozen.")

    def _named(self, kind: type, packages: Sequence[str], names: Sequence[str]) -> int:
        """Enter a class into the table of classes; return its place there."""
        if _package(kind.__module__) not in packages or "." in kind.__qualname__:
            raise TypeError(f"{kind.__module__}.{kind.__qualname__} may not be named in a file.")
        self.classes.append([f"{kind.__module__}:{kind.__qualname__}", list(names)])
        return len(self.classes) - 1

    def _items(self, values: Iterable[Any]) -> list[Any]:
        return [self.frozen(each) for each in values]

    def _integer(self, value: int) -> Any:
        return value if -(2**63) <= value < 2**64 else {"n": str(value)}

    def _dataclass(self, value: Any) -> Any:
        place, names = self._known[type(value)]
        frozen = self.frozen
        return {"$": [place, *[frozen(getattr(value, name)) for name in names]]}

    def _model(self, value: BaseModel) -> Any:
        members = {name: self.frozen(each) for name, each in value.model_dump().items()}
        return {"&": [self._known[type(value)][0], members]}

    def _array(self, value: NDArray[Any]) -> Any:
        known = self._arrays.get(id(value))
        if known is None:
            order = _order(value)
            place = [*self._added(value if order is None else value.transpose(order)), order, *value.shape]
            known = self._arrays[id(value)] = value, {"#": place}
        return known[1]

    def _scalar(self, value: np.generic) -> Any:
        return {".": self._added(np.asarray(value))}

    def _bytes(self, value: bytes) -> list[int]:
        return [*self._added(np.frombuffer(value, BYTES)), len(value)]

    def _added(self, array: NDArray[Any]) -> tuple[int, int]:
        """Put the numbers of an array with those of their type: which buffer, and where in it."""
        place = self._places.get(array.dtype)
        if place is None:
            if array.dtype.hasobject:
                raise TypeError("An array of objects cannot be frozen.")
            place = self._places[array.dtype] = len(self.buffers)
            self.buffers.append(_Buffer(array.dtype))
        return place, self.buffers[place].add(array)


def _real(value: float) -> Any:
    return value if math.isfinite(value) else {"n": str(value)}


def _order(array: NDArray[Any]) -> list[int] | None:
    """Axes in the order of memory, outermost first, where that is not their own.

    Sums depend in their last bits on the order in which numpy goes through memory.
    """
    if array.flags.c_contiguous:
        return None
    order = sorted(range(array.ndim), key=lambda axis: -abs(array.strides[axis]))
    return None if order == list(range(array.ndim)) else order


class _Thawer:
    """Turns what JSON has back into values; classes are looked up before any value is made."""

    def __init__(self, buffers: Sequence[NDArray[Any]], classes: Sequence[tuple[str, Sequence[str]]]) -> None:
        self._buffers = buffers
        self._classes: list[Any] = [_resolved(name) for name, _ in classes]
        self._names = [names for _, names in classes]
        self._ways: dict[str, Callable[[Any], Any]] = {
            "$": self._dataclass,
            "&": self._model,
            "#": self._array,
            ".": lambda body: self._buffers[body[0]][body[1]],
            "b": self._bytes,
            "g": lambda body: _shapely().from_wkb(self._bytes(body)),
            "l": lambda body: [self.thawed(each) for each in body],
            "d": lambda body: {self.thawed(key): self.thawed(each) for key, each in body},
            "n": _number,
        }

    def thawed(self, value: Any) -> Any:
        """The value that a piece of the JSON text stands for."""
        kind = type(value)
        if kind is list:
            return tuple([self.thawed(each) for each in value])
        if kind is dict:
            ((tag, body),) = value.items()
            return self._ways[tag](body)
        return value

    def _dataclass(self, body: list[Any]) -> Any:
        values = [self.thawed(each) for each in body[1:]]
        return self._classes[body[0]](**dict(zip(self._names[body[0]], values, strict=True)))

    def _model(self, body: tuple[int, Mapping[str, Any]]) -> Any:
        kind: type[BaseModel] = self._classes[body[0]]
        return kind.model_validate({name: self.thawed(each) for name, each in body[1].items()})

    def _array(self, body: list[Any]) -> NDArray[Any]:
        place, start, order, *shape = body
        numbers: NDArray[Any] = self._buffers[place][start : start + math.prod(shape)]
        if order is None:
            return numbers if len(shape) == 1 else numbers.reshape(shape)
        return numbers.reshape([shape[axis] for axis in order]).transpose(np.argsort(order))

    def _bytes(self, body: tuple[int, int, int]) -> bytes:
        place, start, size = body
        return self._buffers[place][start : start + size].tobytes()


def _number(text: str) -> int | float:
    """A number written as text."""
    return float(text) if text in {"nan", "inf", "-inf"} else int(text)


def _resolved(name: str) -> type:
    """The class that a file names; it must be a dataclass or a model of the packages that may be named."""
    module, _, attribute = name.partition(":")
    if _package(module) not in {*DATACLASSES, *MODELS}:
        raise FrozenError(f"{name} may not be named in a file.")
    kind = getattr(import_module(module), attribute)
    if isinstance(kind, type) and kind.__module__ == module:
        if is_dataclass(kind) and _package(module) in DATACLASSES:
            return kind
        if issubclass(kind, BaseModel) and _package(module) in MODELS:
            return kind
    raise FrozenError(f"{name} may not be named in a file.")


def _package(module: str) -> str:
    return module.partition(".")[0]


def _shapely() -> Any:
    """The library of geometries, imported where there are any: the web process starts without it."""
    return import_module("shapely")
