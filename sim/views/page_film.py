"""The pictures of a film, taken from the replay page."""

from __future__ import annotations

import io
import json
import tempfile
from pathlib import Path
from typing import Any, Literal

import numpy as np

from floorplan import UserError

from ..record.outcome import Outcome
from .chromium import Browser
from .replay import render
from .replay_data import replay_data

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
