"""Pages in an invisible browser: films and prints."""

from __future__ import annotations

import asyncio
import io
import math
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from floorplan import UserError

from ..record.outcome import Outcome, span_of
from ..record.output import replacing, writing
from ..record.sampling import Span
from .replay import render as render_page
from .replay_data import replay_data
from .report_page import MissingExtraError, require_place

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "msedge"),
)
"""Commands of supported browsers."""

PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
)
"""Files of browsers, if there is no such command."""

ARGUMENTS = (
    "--disable-gpu",
    # WebGL in software looks the same on every machine.
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
)

PATIENCE = 60_000.0
"""Milliseconds. Timeout of one action of the browser."""

Result = TypeVar("Result")


class BrowserError(UserError):
    """Error of a browser that failed or did not answer in time."""


def installed_chromium() -> str | None:
    """Return the path of an installed browser of Chromium's kind, or None.

    The environment variable CHROMIUM takes precedence.
    """
    named = [os.environ.get("CHROMIUM", ""), *NAMES]
    command = next(filter(None, map(shutil.which, filter(None, named))), None)
    return command or next((place for place in PLACES if Path(place).is_file()), None)


def require_browser(what: str) -> str:
    """Return the path of the browser. `MissingExtraError` if it or Playwright is missing.

    `what` is the output that needs it, as the subject of the message.
    """
    try:
        import playwright as playwright
    except ImportError:
        raise MissingExtraError(
            f"{what} needs the package playwright, which is missing:"
            " pip install 'floorwalker[film]'"
        ) from None
    browser = installed_chromium()
    if browser is None:
        raise MissingExtraError(
            f"{what} needs Chromium or Chrome, and none is found: install one, or name it in the"
            " environment variable CHROMIUM"
        )
    return browser


def in_browser(what: str, work: Callable[[Browser], Result]) -> Result:
    """Return the result of `work` with a browser, which is closed afterwards.

    `MissingExtraError` as in `require_browser`, `BrowserError` if the browser fails.
    """
    command = require_browser(what)
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return _opened(command, work)
    # Playwright's blocking interface rejects a thread with an event loop, as in a notebook.
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(_opened, command, work).result()


def _opened(command: str, work: Callable[[Browser], Result]) -> Result:
    from playwright.sync_api import Error, sync_playwright

    try:
        with sync_playwright() as driver:
            browser = driver.chromium.launch(
                executable_path=command,
                args=ARGUMENTS,
                # The administrator, as whom containers run, cannot use the sandbox.
                chromium_sandbox=sys.platform == "win32" or os.geteuid() != 0,
                timeout=PATIENCE,
            )
            return work(browser)
    except Error as why:
        raise BrowserError(f"{command} failed: {why.message.splitlines()[0]}") from None


def open_page(
    browser: Browser, file: Path, *, size: tuple[int, int] = (1000, 640), dark: bool = False
) -> Page:
    """Return the loaded page of an HTML file, `size` pixels wide and high."""
    width, height = size
    page = browser.new_page(
        viewport={"width": width, "height": height}, color_scheme="dark" if dark else "light"
    )
    page.set_default_timeout(PATIENCE)
    page.goto(file.resolve().as_uri())
    page.wait_for_selector("body:not([aria-busy=true])")
    return page


ENDINGS = (".gif", ".mp4")

View = Literal["2d", "3d", "eyes"]
"""From above, in three dimensions, or from the position of a person."""

MOST_PICTURES = 20_000
"""Maximum number of pictures of a film."""

WIDE = 9 / 16
"""Height by width of a film in three dimensions."""

MARGIN = 24
"""Pixels above and below the floor."""

SAMPLES = 12
"""Number of pictures from which the colours of a GIF are chosen."""

SETTLED = 4
"""Number of equal pictures after which a page of a new size counts as shown."""

Picture = NDArray[np.uint8]
"""Red, green and blue of every pixel from the upper left corner on, (height, width, 3)."""

Progress = Callable[[float], None]
"""Function called with the finished share, from 0 to 1."""

_DRAWN = "new Promise(done => requestAnimationFrame(() => setTimeout(done)))"


def render(
    run: Outcome,
    path: str | Path,
    *,
    speed: float = 8.0,
    fps: int = 20,
    width: int = 720,
    within: Span | None = None,
    view: View = "2d",
    follow: str = "",
    dark: bool = False,
    progress: Progress = lambda _: None,
) -> None:
    """Film a run into a GIF or MP4 file.

    Parameters
    ----------
    run : Run
        Finished or loaded run.
    path : str or Path
        File that ends in .gif or .mp4.
    speed : float, optional
        Simulated seconds per second of the film.
    fps : int, optional
        Pictures per second, 1 to 50.
    width : int, optional
        Width in pixels, 200 to 4000.
    within : (float, float), optional
        Begin and end in seconds. Defaults to the whole run.
    view : {"2d", "3d", "eyes"}, optional
        View of the replay page: from above, in three dimensions, or through the eyes of a person.
    follow : str, optional
        Body in the centre of the view, or the person of the "eyes".
    dark : bool, optional
        Whether the page is dark.
    progress : callable, optional
        Function called with the finished share after each picture.

    Raises
    ------
    ValueError
        If a value is invalid, or if the suffix is neither .gif nor .mp4.
    MissingExtraError
        If the browser or a package of the extra `film` is missing.
    OutputError
        If the file cannot be written.
    """
    path = Path(path)
    require_renderable(path)
    if follow and follow not in run.scene.starts:
        bodies = ", ".join(run.scene.starts)
        raise UserError(f"nobody is called {follow!r}, to be followed (there are: {bodies})")
    if not 200 <= width <= 4000:
        raise UserError(f"width must be from 200 to 4000 pixels, not {width}")
    times = _times(run, speed, fps, within)
    size = _size(run, width, view)
    look = {"view": view, "speed": speed, "follow": follow}
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4

    def film(browser: Browser) -> None:
        with tempfile.TemporaryDirectory(prefix="floorwalker") as folder:
            file = Path(folder) / "replay.html"
            file.write_text(render_page(replay_data(run)), encoding="utf-8")
            page = open_page(browser, file, size=size, dark=dark)
        page.evaluate("look => floorwalker.film(look)", look)
        _settle(page)
        write(page, times, unfinished, fps, progress)

    with writing(path), replacing(path) as unfinished:
        in_browser("a film", film)


def require_renderable(path: str | Path) -> None:
    """Raise the errors of `render` that can be found before the film is made.

    Parameters
    ----------
    path : str or Path
        File.

    Raises
    ------
    ValueError
        If the suffix is neither .gif nor .mp4.
    OutputError
        If the folder does not exist.
    MissingExtraError
        If the browser or a package of the extra `film` is missing.
    """
    require_place(path, "film", ENDINGS)
    require_browser("a film")
    package = "PIL" if Path(path).suffix.lower() == ".gif" else "av"
    try:
        __import__("PIL.Image")
        __import__(package)
    except ImportError as why:
        raise MissingExtraError(
            f"a film needs the package {why.name}, which is missing:"
            " pip install 'floorwalker[film]'"
        ) from None


def _times(run: Outcome, speed: float, fps: int, within: Span | None) -> list[float]:
    """Return the times (s) of the pictures. `UserError` if they make no film."""
    if not (math.isfinite(speed) and speed > 0):
        raise UserError(f"speed must be more than 0, not {speed:g}")
    if not 1 <= fps <= 50:
        raise UserError(f"fps must be from 1 to 50, not {fps}")
    begin, end = span_of(run, within)
    count = int((end - begin) * fps / speed + 1e-9) + 1
    if count > MOST_PICTURES:
        raise UserError(
            f"that would be {count:,} pictures, more than {MOST_PICTURES:,};"
            " choose a higher speed or a shorter stretch of time"
        )
    times: list[float] = np.minimum(begin + np.arange(count) * (speed / fps), end).tolist()
    return times


def _size(run: Outcome, width: int, view: View) -> tuple[int, int]:
    """Return width and height in pixels, both even, as video requires."""
    west, south, east, north = run.floorplan.boundary.bounds
    height = width * WIDE
    if view == "2d":
        height = width * (north - south) / (east - west) + 2 * MARGIN
    return 2 * (width // 2), 2 * round(min(height, 2 * width) / 2)


def _settle(page: Page) -> None:
    """Wait until the browser shows the page's new size.

    Its compositor runs concurrently, and the first pictures may lack a canvas that was drawn.
    """
    latest: list[bytes] = []
    while len(latest) < SETTLED or len(set(latest[-SETTLED:])) > 1:
        page.evaluate(_DRAWN)
        latest.append(page.screenshot())


def _pictures(page: Page, times: Sequence[float]) -> Iterator[Picture]:
    from PIL import Image

    for t in times:
        page.evaluate(f"(floorwalker.seek({t!r}), {_DRAWN})")
        with Image.open(io.BytesIO(page.screenshot())) as picture:
            yield np.asarray(picture.convert("RGB"))


def _counted(pictures: Iterator[Picture], count: int, progress: Progress) -> Iterator[Picture]:
    """Yield the pictures, and report the finished share of `count` after each."""
    for k, picture in enumerate(pictures, 1):
        yield picture
        progress(k / count)


def _write_gif(
    page: Page, times: Sequence[float], path: Path, fps: int, progress: Progress
) -> None:
    from PIL import Image

    # One palette for the whole film, so that no colour flickers.
    chosen = np.vstack([*_pictures(page, times[:: max(1, len(times) // SAMPLES)])])
    palette = Image.fromarray(chosen).quantize(method=Image.Quantize.FASTOCTREE)
    images = (
        Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
        for picture in _counted(_pictures(page, times), len(times), progress)
    )
    first = next(images)
    first.save(path, save_all=True, append_images=images, duration=1000 / fps, loop=0)


def _write_mp4(
    page: Page, times: Sequence[float], path: Path, fps: int, progress: Progress
) -> None:
    import av

    with av.open(path, "w") as file:
        # x264's code for single CPUs reads uninitialized memory (its macroblock tree).
        options = {"threads": "1", "x264-params": "cpu-independent=1"}
        stream = file.add_stream("libx264", rate=fps, options=options)
        size = page.viewport_size
        assert size is not None  # as `open_page` sets it
        stream.width, stream.height = size["width"], size["height"]
        stream.pix_fmt = "yuv420p"
        for picture in _counted(_pictures(page, times), len(times), progress):
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        file.mux(stream.encode())
