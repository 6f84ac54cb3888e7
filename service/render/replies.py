"""The answer to an execute request: in which form, and as it is or in a JSON document (18-062r2 §7.11)."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass

import orjson

from service.intake import Reply, refuse
from service.render.forms import FORMS

__all__ = ["Settled", "enclose", "settle"]

_JSON = "application/json"


@dataclass(frozen=True, slots=True)
class Settled:
    """What is answered: a form of the result, and whether a document holds it."""

    form: str
    document: bool = False

    @property
    def media_type(self) -> str:
        """That of the whole answer."""
        return _JSON if self.document else FORMS[self.form]


def settle(reply: Reply, form: str, decided: bool, offered: Sequence[str]) -> Settled:
    """Join what the head of a request asks for with what its body does.

    Parameters
    ----------
    reply : Reply
        What the body says.
    form : str
        What has been negotiated.
    decided : bool
        Whether the head names a form; then the body's counts only inside of a document.
    offered : sequence of str
        Keys of `FORMS`, the preferred one first.

    Raises
    ------
    IntakeError
        422 for a media type that is not offered, and for a document that is not to be JSON.
    """
    wanted = None if reply.media_type is None else _form(reply.media_type, offered)
    if not reply.document:
        return Settled(form if decided or wanted is None else wanted)
    if decided and FORMS[form] != _JSON:
        detail = "a document is JSON: accept that, and name the form that it shall hold in outputs"
        raise refuse("invalid-input", detail, ("body", "response"), "not_acceptable")
    return Settled(wanted or offered[0], document=True)


def _form(media_type: str, offered: Sequence[str]) -> str:
    name = media_type.partition(";")[0].strip().lower()
    form = next((form for form in offered if FORMS[form] == name), None)
    if form is None:
        listed = ", ".join(FORMS[one] for one in offered)
        loc = ("body", "outputs", "result", "format", "mediaType")
        raise refuse("invalid-input", f"offered are {listed}", loc, "enum")
    return form


def enclose(content: bytes, form: str) -> bytes:
    """Put a rendered result in a document: JSON as it is, text as a string, octets in base64."""
    media_type = FORMS[form]
    told = {"mediaType": media_type}
    if media_type.endswith("json"):
        value = content
    elif media_type.startswith("text/") or media_type.endswith("+xml"):
        value = orjson.dumps(content.decode())
    else:
        value = orjson.dumps(base64.b64encode(content).decode())
        told["encoding"] = "base64"
    return b'{"result":{"value":' + value + b"," + orjson.dumps(told)[1:] + b"}"
