"""Web pages that may take part: a browser sends the origin of the page that opens a connection.

Without these checks any page that is open in a browser on this machine could drive the person: a
browser lets pages of all hosts open websockets, and post, to all hosts, the loopback included.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Iterable
from urllib.parse import urlsplit

from floorplan import UserError

_LOOPBACK = re.compile(r"https?://(localhost|127(\.\d{1,3}){3}|\[::1\])(:\d{1,5})?")
_ORIGIN = re.compile(r"null|[a-z][a-z0-9+.-]*://[^\s/?#@,]*")
_USUAL_PORTS = {"http": ":80", "https": ":443"}


def names_this_machine(host: str) -> bool:
    """Return whether a Host header names this machine as such, not by a name that leads to it."""
    return _LOOPBACK.fullmatch(f"http://{host}") is not None


def is_own(origin: str, host: str) -> bool:
    """Return whether an origin ("" for no page) is that of a page which `host` itself has sent."""
    return origin in ("", f"http://{host}")


class OriginError(UserError):
    """A text that is no origin of a web page."""


class Origins:
    """Trusts clients that are no web pages, pages of this machine, and those of `named` origins.

    An origin is as `http://host:port`, or `null`: that is sent for a page from a file, and for
    any page that hides where it comes from. `OriginError` where something else is named.
    """

    def __init__(self, named: Iterable[str] = ()) -> None:
        self._named = set()
        for origin in named:
            normal = _normal(origin)
            if not _ORIGIN.fullmatch(normal):
                raise OriginError(
                    f"{origin!r} is no origin of a page; one looks like http://host:8080"
                )
            self._named.add(normal)

    def trust(self, origin: str, host: str) -> bool:
        """Return whether a client of `origin` may take part; `host` is its name for the server.

        Some clients that are no browsers send the server's own address, and old ones leave out the
        scheme, which browsers don't. With an IP address that is safe, since no page comes from
        here. A name may be an attacker's, who has it lead to this machine once the page is loaded
        (DNS rebinding).
        """
        normal = _normal(origin)
        if "://" not in normal and normal != "null":
            normal = f"http://{normal}"
        if normal in self._named or _LOOPBACK.fullmatch(normal):
            return True
        return _is_number(host) and normal in (_normal(f"{s}://{host}") for s in _USUAL_PORTS)


def _normal(origin: str) -> str:
    """Return an origin as browsers send it: in lower case, without the default port."""
    origin = origin.lower()
    return origin.removesuffix(_USUAL_PORTS.get(origin.partition("://")[0], "/"))


def _is_number(host: str) -> bool:
    """Whether a Host header has an IP address, not a name."""
    try:
        ipaddress.ip_address(urlsplit(f"//{host}").hostname or "")
    except ValueError:
        return False
    return True
