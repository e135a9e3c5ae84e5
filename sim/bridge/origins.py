"""Web pages that may take part: a browser says which page opens a connection, as its origin.

Without this check any page that is open in a browser on this machine could drive the person: a
browser lets pages of all hosts open websockets to all hosts, the loopback included.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

_LOOPBACK = re.compile(r"https?://(localhost|127(\.\d{1,3}){3}|\[::1\])(:\d{1,5})?")
_ORIGIN = re.compile(r"null|[a-z][a-z0-9+.-]*://[^\s/?#@,]*")
_USUAL_PORTS = {"http": ":80", "https": ":443"}


class OriginError(ValueError):
    """Something that is no origin of a web page."""


class Origins:
    """Trusts clients that are no web pages, pages of this machine, and those of `named` origins.

    An origin is as `http://host:port`, or `null`: that is sent for a page from a file, and for
    any page that hides where it comes from. `OriginError` where something else is named.
    """

    def __init__(self, named: Iterable[str] = ()) -> None:
        self._named = {_normal(origin) for origin in named}
        for origin in self._named:
            if not _ORIGIN.fullmatch(origin):
                raise OriginError(
                    f"{origin!r} is no origin of a page; one looks like http://host:8080"
                )

    def trust(self, origin: str) -> bool:
        """Whether a page of that origin may take part."""
        normal = _normal(origin)
        return normal in self._named or _LOOPBACK.fullmatch(normal) is not None


def _normal(origin: str) -> str:
    """An origin as browsers send it: in small letters, without the port that is usual."""
    origin = origin.lower()
    return origin.removesuffix(_USUAL_PORTS.get(origin.partition("://")[0], "/"))
