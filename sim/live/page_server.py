"""Server of a page for a browser on this machine, with a stream of messages and requests.

The messages of the stream are server-sent events of HTML over plain HTTP. A browser resumes the
stream after the last message it has received. Requests are posts of JSON.

The checks of origins are necessary because browsers allow pages of all hosts to open websockets and
to post to this machine, so that any open page could control the run.
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
"""Returns the answer to a request, both as JSON. With a `problem`, the request has failed."""

SIGN_OF_LIFE = 5.0
"""Seconds between two comments on a quiet stream, which show whether a reader is gone."""


class MessageStream:
    """Messages since the first one, so that late readers get all of them."""

    def __init__(self) -> None:
        self._messages: list[bytes] = []
        self._changed = threading.Condition()
        self._closed = False
        self._readers: dict[int, int] = {}
        self._ever_read = False

    def send(self, data: str, event: str = "message") -> None:
        """Add a message of one line, with its kind of event."""
        with self._changed:
            number = len(self._messages)
            self._messages.append(f"id: {number}\nevent: {event}\ndata: {data}\n\n".encode())
            self._changed.notify_all()

    def close(self) -> None:
        """End the stream."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def messages(self, first: int = 0) -> Iterator[bytes]:
        """Yield all messages from number `first` on, and comments while there are none."""
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
        """Wait for a reader for at most `seconds`. Return whether there was one."""
        with self._changed:
            return self._changed.wait_for(lambda: self._ever_read, seconds)

    def wait_until_read(self, seconds: float) -> bool:
        """Wait for at most `seconds` until all readers have read all messages."""

        def read() -> bool:
            return all(done >= len(self._messages) for done in self._readers.values())

        with self._changed:
            return self._changed.wait_for(read, seconds)


class PageServer:
    """Server of a page at `url` in its own thread, with a stream at `url`stream.

    Only programs on this machine can reach it, and no page of another host in a browser. `port` 0
    is any free one. If the page has `control` (posts to `url`control), its address contains a
    secret, so that other users of this machine cannot control the run.
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
        """Address of the page."""
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
        """Ignore a browser that disconnects."""


class _Handler(BaseHTTPRequestHandler):
    root: str
    make_page: Callable[[], str]
    messages: MessageStream | None
    answer: Control | None

    def do_HEAD(self) -> None:
        """Answer with the headers of a GET."""
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
        """Answer a request of the page itself. Browsers send the origin of the page."""
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
        """Return the posted JSON, or None if it is invalid."""
        length = self.headers.get("Content-Length", "")
        kind = self.headers.get_content_type()
        if kind != "application/json" or not length.isdecimal() or int(length) > LONGEST_REQUEST:
            return None
        try:
            return json.loads(self.rfile.read(int(length)))
        except ValueError:
            return None

    def log_message(self, format: str, *values: object) -> None:
        """Log nothing."""

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
    """Return whether a Host header is an address of this machine, and no name that means one."""
    return _LOOPBACK.fullmatch(f"http://{host}") is not None


def is_own(origin: str, host: str) -> bool:
    """Return whether an origin is that of a page of `host`, or empty, which is no page."""
    return origin in ("", f"http://{host}")


class OriginError(UserError):
    """Text that is no origin of a web page."""


class Origins:
    """Trusted clients: all that are no web pages, pages of this machine, and `named` origins.

    An origin is `http://host:port`, or `null`, which browsers send for pages from files and for
    pages that hide their origin. `OriginError` for other texts.
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
        """Return whether a client of `origin` is accepted. `host` is its name for the server.

        Some clients that are no browsers send the address of the server, and old ones omit the
        scheme, unlike browsers. An IP address is safe, because no page comes from here. A name may
        belong to an attacker, and resolve to this machine after the page is loaded (DNS rebinding).
        """
        normal = _normal(origin)
        if "://" not in normal and normal != "null":
            normal = f"http://{normal}"
        if normal in self._named or _LOOPBACK.fullmatch(normal):
            return True
        return _is_number(host) and normal in (_normal(f"{s}://{host}") for s in _USUAL_PORTS)


def _normal(origin: str) -> str:
    """Return an origin as browsers send it, in lower case and without the default port."""
    origin = origin.lower()
    return origin.removesuffix(_USUAL_PORTS.get(origin.partition("://")[0], "/"))


def _is_number(host: str) -> bool:
    """Return whether a Host header is an IP address, not a name."""
    try:
        ipaddress.ip_address(urlsplit(f"//{host}").hostname or "")
    except ValueError:
        return False
    return True
