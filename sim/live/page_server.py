"""A page for a browser on this machine, and a stream of messages that the page can follow.

The messages are server-sent events, as HTML defines them: plain HTTP, which a browser resumes
from the last message that it has seen.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType

HOST = "127.0.0.1"
SIGN_OF_LIFE = 5.0
"""Seconds between two signs of life on a quiet stream, which show that a reader is gone."""


class Stream:
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
    whatever name it calls this machine by. `port` 0 takes any that is free.
    """

    def __init__(
        self, page: Callable[[], str], *, stream: Stream | None = None, port: int = 0
    ) -> None:
        class Handler(_Handler):
            make_page = staticmethod(page)
            messages = stream

        try:
            self._server = _Server((HOST, port), Handler)
        except OSError as why:
            raise OSError(f"can't serve at {HOST}:{port}: {why.strerror}") from None
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{HOST}:{self._server.server_port}/"

    def __enter__(self) -> PageServer:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore a browser that goes away in the middle."""


class _Handler(BaseHTTPRequestHandler):
    make_page: Callable[[], str]
    messages: Stream | None

    def do_HEAD(self) -> None:
        """Answer as a GET, with the headers alone."""
        self.do_GET()

    def do_GET(self) -> None:
        host = self.headers.get("Host", "").rpartition(":")[0]
        if host not in (HOST, "localhost"):
            self.send_error(HTTPStatus.FORBIDDEN)
        elif self.path == "/":
            self._send_page()
        elif self.path == "/stream" and self.messages is not None:
            self._send_stream(self.messages)
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def log_message(self, format: str, *values: object) -> None:
        """Write no log of requests."""

    def _send_page(self) -> None:
        content = self.make_page().encode()
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def _send_stream(self, stream: Stream) -> None:
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
