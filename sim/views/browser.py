"""Headless Chromium, and the frames of a film that it takes of the replay page."""

from __future__ import annotations

import base64
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Literal
from urllib.request import urlopen

import numpy as np

from floorplan import UserError

from ..record.outcome import Outcome
from .replay import render
from .replay_data import replay_data
from .report_page import MissingExtraError

NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "msedge"),
)
"""Commands that are looked for."""

PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
)
"""Files that are looked for where there is no such command."""

QUIET = (
    *("--disable-gpu", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--disable-extensions"),
)
"""Arguments of a browser that nobody sees, and that asks the network for nothing."""

ARGUMENTS = (
    *("--headless=new", "--remote-debugging-port=0", "--hide-scrollbars", *QUIET),
    *("--disable-quic", "--mute-audio"),
    # WebGL in software looks the same on every machine.
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
)

PATIENCE = 60.0
"""Seconds that the browser may take for one thing."""


class BrowserError(UserError):
    """The browser does not do what it should."""


def installed_chromium() -> str | None:
    """Return the command of a browser of Chromium's kind, None where there is none.

    The environment variable CHROMIUM goes before all others.
    """
    named = [os.environ.get("CHROMIUM", ""), *NAMES]
    found = next(filter(None, map(shutil.which, filter(None, named))), None)
    return found or next((place for place in PLACES if Path(place).is_file()), None)


def unboxed() -> tuple[str, ...]:
    """Return the argument that the administrator, as whom containers run, can't do without.

    A sandbox of its own is refused to them.
    """
    return ("--no-sandbox",) if sys.platform != "win32" and os.geteuid() == 0 else ()


def find_chromium() -> str:
    """Return `installed_chromium`; `MissingExtraError` if there is none."""
    found = installed_chromium()
    if found is None:
        raise MissingExtraError(
            "pictures of the replay page need Chromium or Chrome, and none is found: install one,"
            " or name it in the environment variable CHROMIUM"
        )
    return found


class Browser:
    """Shows one page, `size` pixels (width, height) large, while it is entered."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.size = size
        self._command = find_chromium()
        self._number = 0

    def __enter__(self) -> Browser:
        from websockets.sync.client import connect

        with ExitStack() as stack:
            folder = stack.enter_context(
                tempfile.TemporaryDirectory(prefix="floorwalker", ignore_cleanup_errors=True)
            )
            process = self._start(folder)
            stack.callback(_end, process)
            address = self._page_address(Path(folder), process)
            self._socket = stack.enter_context(
                connect(address, max_size=None, open_timeout=PATIENCE)
            )
            width, height = self.size
            screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
            self._call("Emulation.setDeviceMetricsOverride", **screen)
            self._opened = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._opened.close()

    def open(self, page: Path, *, dark: bool = False) -> None:
        """Show the page in a file, and wait until it is ready."""
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self._call("Emulation.setEmulatedMedia", features=[scheme])
        self._call("Page.navigate", url=page.resolve().as_uri())
        until = time.monotonic() + PATIENCE
        while not self.evaluate("document.body?.ariaBusy === 'false'"):
            if time.monotonic() > until:
                raise BrowserError("the page is not ready in time")
            time.sleep(0.05)

    def evaluate(self, script: str) -> Any:
        """Return what a script of the page comes to, or what it promises."""
        answer = self._call(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        if "exceptionDetails" in answer:
            why = answer["exceptionDetails"].get("exception", {}).get("description", "")
            raise BrowserError(f"the page fails: {why.splitlines()[0] if why else script}")
        return answer["result"].get("value")

    def picture(self) -> bytes:
        """Return what is shown, as PNG."""
        answer = self._call("Page.captureScreenshot", format="png", optimizeForSpeed=True)
        return base64.b64decode(answer["data"])

    def cpu_times(self) -> tuple[float, float]:
        """Return the CPU times (s) so far of the page's main thread, and of the scripts in it."""
        self._call("Performance.enable", timeDomain="threadTicks")
        found = {m["name"]: m["value"] for m in self._call("Performance.getMetrics")["metrics"]}
        return float(found["ThreadTime"]), float(found["ScriptDuration"])

    def _start(self, folder: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [self._command, *ARGUMENTS, *unboxed(), f"--user-data-dir={folder}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def _page_address(self, folder: Path, process: subprocess.Popen[bytes]) -> str:
        """Return the address at which the browser lets the page be driven."""
        port = folder / "DevToolsActivePort"
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until and process.poll() is None:
            lines = port.read_text().splitlines() if port.exists() else []
            if len(lines) > 1:
                with urlopen(f"http://127.0.0.1:{lines[0]}/json/list", timeout=PATIENCE) as answer:
                    pages = [one for one in json.load(answer) if one["type"] == "page"]
                if pages:
                    return str(pages[0]["webSocketDebuggerUrl"])
            time.sleep(0.05)
        raise BrowserError(f"{self._command} does not start")

    def _call(self, method: str, **params: Any) -> dict[str, Any]:
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": params}))
        while True:
            try:
                answer = json.loads(self._socket.recv(PATIENCE))
            except (TimeoutError, OSError, EOFError) as why:
                raise BrowserError(f"{self._command} does not answer: {why}") from None
            if answer.get("id") != self._number:
                continue
            if "error" in answer:
                raise BrowserError(f"{self._command}: {answer['error'].get('message')}")
            result: dict[str, Any] = answer["result"]
            return result


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


View = Literal["2d", "3d", "eyes"]
"""From above, in three dimensions, or through somebody's eyes."""

_WIDE = 9 / 16
"""Height by width of a film in three dimensions."""

_MARGIN = 24
"""Pixels above the floor and below it."""

_DRAWN = "new Promise(done => requestAnimationFrame(() => setTimeout(done)))"


class PageFilm:
    """Pictures of a run as its replay page shows it, while it is entered.

    They are `width` pixels wide. The film goes `speed` times as fast as in reality; `follow` is the
    body that is kept in the middle, or the person whose eyes are looked through.
    """

    def __init__(
        self,
        run: Outcome,
        *,
        width: int,
        view: View,
        speed: float,
        follow: str = "",
        dark: bool = False,
    ) -> None:
        if follow and follow not in run.scene.starts:
            known = ", ".join(run.scene.starts)
            raise UserError(f"nobody is called {follow!r}, to be followed (there are: {known})")
        self._run = run
        self._look = {"view": view, "speed": speed, "follow": follow}
        self._dark = dark
        west, south, east, north = run.floorplan.boundary.bounds
        high = _WIDE if view != "2d" else (north - south) / (east - west)
        height = width * high + (2 * _MARGIN if view == "2d" else 0)
        # Video wants an even number of pixels each way.
        self.size = 2 * (width // 2), 2 * round(min(height, 2 * width) / 2)
        self._browser = Browser(self.size)

    def __enter__(self) -> PageFilm:
        self._browser.__enter__()
        try:
            with tempfile.TemporaryDirectory(prefix="floorwalker") as folder:
                page = Path(folder) / "replay.html"
                page.write_text(render(replay_data(self._run)), encoding="utf-8")
                self._browser.open(page, dark=self._dark)
            self._browser.evaluate(f"floorwalker.film({json.dumps(self._look)})")
            self._browser.evaluate(_DRAWN)
        except BaseException:
            self._browser.__exit__(None, None, None)
            raise
        return self

    def __exit__(self, *why: object) -> None:
        self._browser.__exit__(*why)

    def at(self, t: float) -> Any:
        """Return the picture of the instant `t` (seconds): rows of red, green and blue."""
        from PIL import Image

        self._browser.evaluate(f"(floorwalker.seek({t!r}), {_DRAWN})")
        with Image.open(io.BytesIO(self._browser.picture())) as picture:
            return np.asarray(picture.convert("RGB"))
