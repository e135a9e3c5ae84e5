"""A page for a browser on this machine, a stream that it can follow, and its requests.

The messages of the stream are server-sent events, as HTML defines them: plain HTTP, which a browser
resumes from the last message that it has seen. Requests are posts of JSON.

Without these checks any page that is open in a browser on this machine could drive the person: a
browser lets pages of all hosts open websockets, and post, to all hosts, the loopback included.
"""

from __future__ import annotations

import ipaddress
import json
import re
import secrets
import threading
from collections.abc import Callable, Iterable, Iterator
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import urlsplit

from floorplan import UserError

HOST = "127.0.0.1"
LONGEST_REQUEST = 65_536
"""Bytes of a request."""

Control = Callable[[Any], dict[str, Any]]
"""Returns the answer to a request, both as JSON; one with a `problem` was not done."""

SIGN_OF_LIFE = 5.0
"""Seconds between two signs of life on a quiet stream, which show that a reader is gone."""


class MessageStream:
    """Messages, kept from the first one on: a reader who comes late gets them all."""

    def __init__(self) -> None:
        self._messages: list[bytes] = []
        self._changed = threading.Condition()
        self._closed = False
        self._readers: dict[int, int] = {}
        self._ever_read = False

    def send(self, data: str, event: str = "message") -> None:
        """Add a message: one line of text, and what kind of event it is."""
        with self._changed:
            number = len(self._messages)
            self._messages.append(f"id: {number}\nevent: {event}\ndata: {data}\n\n".encode())
            self._changed.notify_all()

    def close(self) -> None:
        """End the stream: there are no more messages."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def messages(self, first: int = 0) -> Iterator[bytes]:
        """Yield all messages from number `first` on, as they come; comments while there is none."""
        reader = threading.get_ident()
        try:
            while True:
                with self._changed:
                    self._readers[reader] = first
                    self._ever_read = True
                    self._changed.notify_all()
                    if len(self._messages) == first and not self._closed:
                        self._changed.wait(SIGN_OF_LIFE)
                    new = self._messages[first:]
                    if not new and self._closed:
                        return
                first += len(new)
                yield b"".join(new) or b":\n\n"
        finally:
            with self._changed:
                self._readers.pop(reader, None)
                self._changed.notify_all()

    def wait_for_reader(self, seconds: float) -> bool:
        """Wait until a reader has begun, but no longer than `seconds`."""
        with self._changed:
            return self._changed.wait_for(lambda: self._ever_read, seconds)

    def wait_until_read(self, seconds: float) -> bool:
        """Wait until all readers have read all messages, but no longer than `seconds`."""

        def read() -> bool:
            return all(done >= len(self._messages) for done in self._readers.values())

        with self._changed:
            return self._changed.wait_for(read, seconds)


class PageServer:
    """Serves a page at `url` from a thread of its own, and a stream beside it, at `url`stream.

    Only this machine can reach it, and no page from elsewhere in a browser on this machine,
    whatever name it calls this machine by. `port` 0 takes any that is free. Where the page has
    `control`, by posts to `url`control, the address has a secret in it, so that only those take
    part who were given it: not everybody who has an account on this machine.
    """

    def __init__(
        self,
        page: Callable[[], str],
        *,
        stream: MessageStream | None = None,
        control: Control | None = None,
        port: int = 0,
    ) -> None:
        self._root = "/" if control is None else f"/{secrets.token_urlsafe(9)}/"

        class Handler(_Handler):
            root = self._root
            make_page = staticmethod(page)
            messages = stream
            answer = None if control is None else staticmethod(control)

        try:
            self._server = _Server((HOST, port), Handler)
        except OSError as why:
            raise OSError(f"can't serve at {HOST}:{port}: {why.strerror}") from None
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{HOST}:{self._server.server_port}{self._root}"

    def __enter__(self) -> PageServer:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore a browser that goes away in the middle."""


class _Handler(BaseHTTPRequestHandler):
    root: str
    make_page: Callable[[], str]
    messages: MessageStream | None
    answer: Control | None

    def do_HEAD(self) -> None:
        """Answer as a GET, with the headers alone."""
        self.do_GET()

    def do_GET(self) -> None:
        if not names_this_machine(self.headers.get("Host", "")):
            self.send_error(HTTPStatus.FORBIDDEN)
        elif self.path == self.root:
            self._send("text/html; charset=utf-8", self.make_page())
        elif self.path == f"{self.root}stream" and self.messages is not None:
            self._send_stream(self.messages)
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """Answer a request of the page itself: a browser names the origin of whoever posts."""
        host, origin = self.headers.get("Host", ""), self.headers.get("Origin", "")
        if not (names_this_machine(host) and is_own(origin, host)):
            self.send_error(HTTPStatus.FORBIDDEN)
        elif self.path != f"{self.root}control" or self.answer is None:
            self.send_error(HTTPStatus.NOT_FOUND)
        elif (wish := self._posted()) is None:
            self.send_error(HTTPStatus.BAD_REQUEST, "expected JSON")
        else:
            answer = self.answer(wish)
            status = HTTPStatus.CONFLICT if "problem" in answer else HTTPStatus.OK
            self._send("application/json", json.dumps(answer), status)

    def _posted(self) -> Any:
        """Return the JSON that was posted, None where it is none."""
        length = self.headers.get("Content-Length", "")
        kind = self.headers.get_content_type()
        if kind != "application/json" or not length.isdecimal() or int(length) > LONGEST_REQUEST:
            return None
        try:
            return json.loads(self.rfile.read(int(length)))
        except ValueError:
            return None

    def log_message(self, format: str, *values: object) -> None:
        """Write no log of requests."""

    def _send(self, kind: str, text: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        content = text.encode()
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def _send_stream(self, stream: MessageStream) -> None:
        last = self.headers.get("Last-Event-ID", "")
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        if self.command == "HEAD":
            return
        for message in stream.messages(int(last) + 1 if last.isdecimal() else 0):
            self.wfile.write(message)
            self.wfile.flush()


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
                    f"{origin!r} is not an origin of a page; one looks like http://host:8080"
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
