"""A run as a moving picture: a GIF, or with ffmpeg an MP4."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.output import OutputError, replacing, writing
from ...record.outcome import Outcome
from .curves import Span, span_of
from .film import Film, Frame
from .style import MissingExtraError, styled

if TYPE_CHECKING:
    from PIL.Image import Image

ENDINGS = (".gif", ".mp4")

MOST_FRAMES = 20_000
"""More pictures than this are refused: somebody has mistaken a speed."""

MARKED = 1.5
"""Seconds of the film for which a violation stays on the floor."""

_COLOURS = 256
"""How many colours a GIF has."""

_SAMPLES = 12
"""From how many pictures, spread over the film, its colours are chosen."""

Progress = Callable[[float], None]
"""Is told the share that is done, from 0 to 1."""


def render(
    run: Outcome,
    path: str | Path,
    *,
    speed: float = 8.0,
    fps: int = 20,
    width: int = 720,
    within: Span | None = None,
    progress: Progress = lambda _: None,
) -> None:
    """Film a run into the GIF or MP4 that the end of `path` names.

    `speed` is how much faster than in reality it goes, `fps` how many pictures a second it has,
    `width` how wide it is in pixels; `within` (from, to in seconds) is what is filmed of it.
    Every picture shows where everybody is at its instant. Errors as for `require_renderable`;
    `ValueError` for figures that make no film.
    """
    path = Path(path)
    require_renderable(path)
    film = Film(run, _times(run, speed, fps, within), width=_checked(width), mark=MARKED * speed)
    frames = _told(film.frames(), len(film.times), progress)
    with writing(path), replacing(path) as unfinished:
        if path.suffix.lower() == ".gif":
            _write_gif(film, frames, unfinished, fps)
        else:
            _write_mp4(film, frames, unfinished, fps)


def require_renderable(path: str | Path) -> None:
    """See, before any work is done for it, whether a run can be filmed into `path`.

    `ValueError` if it ends in neither .gif nor .mp4, `MissingExtraError` if what is needed for
    it is not there, `OutputError` if there is no such folder.
    """
    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        raise ValueError(f"{path}: the name of a film ends in {' or '.join(ENDINGS)}")
    if not path.parent.is_dir():
        raise OutputError(f"can't write {path}: there is no folder {path.parent}")
    with styled():
        pass
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise MissingExtraError(
            "an MP4 needs the program ffmpeg, which is not on the path; install it, or write a .gif"
        )


def _times(run: Outcome, speed: float, fps: int, within: Span | None) -> Any:
    if not (math.isfinite(speed) and speed > 0):
        raise ValueError(f"a film's speed is more than 0, not {speed:g}")
    if not 1 <= fps <= 50:
        raise ValueError(f"a film has 1 to 50 pictures a second, not {fps}")
    begin, end = span_of(run, within)
    count = int((end - begin) * fps / speed + 1e-9) + 1
    if count > MOST_FRAMES:
        raise ValueError(
            f"that would be {count:,} pictures, more than {MOST_FRAMES:,};"
            " choose a higher speed or a shorter stretch of time"
        )
    return np.minimum(begin + np.arange(count) * (speed / fps), end)


def _checked(width: int) -> int:
    if not 200 <= width <= 4000:
        raise ValueError(f"a film is 200 to 4000 pixels wide, not {width}")
    return width


def _told(frames: Iterator[Frame], count: int, progress: Progress) -> Iterator[Frame]:
    for k, frame in enumerate(frames, 1):
        yield frame
        progress(k / count)


def _write_gif(film: Film, frames: Iterator[Frame], path: Path, fps: int) -> None:
    from PIL import Image

    palette = _palette(film)
    images = (
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    )
    # What is drawn is at hand only once: PIL takes the first picture, and the others as they come.
    first = next(images)
    first.save(path, save_all=True, append_images=images, duration=1000 / fps, loop=0)


def _palette(film: Film) -> Image:
    """The colours of the whole film, so that none flicker: chosen from pictures all over it."""
    from PIL import Image

    chosen = film.times[:: max(1, len(film.times) // _SAMPLES)]
    wide, high = film.size
    strip = Image.new("RGB", (wide, high * len(chosen)))
    for k, frame in enumerate(film.at(chosen).frames()):
        strip.paste(Image.fromarray(frame), (0, k * high))
    return strip.quantize(_COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)


def _write_mp4(film: Film, frames: Iterator[Frame], path: Path, fps: int) -> None:
    wide, high = film.size
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{wide}x{high}", "-r", str(fps)]
    exact = ["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"]
    command = ["ffmpeg", "-v", "error", "-y", *raw, "-i", "-", "-pix_fmt", "yuv420p", *exact]
    with TemporaryFile() as complaints:
        process = subprocess.Popen(
            [*command, str(path.resolve())],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=complaints,
        )
        assert process.stdin is not None
        try:
            for frame in frames:
                process.stdin.write(frame.tobytes())
            process.stdin.close()
        except BrokenPipeError:
            pass  # it says below why it would not have more
        finally:
            status = process.wait()
        if status != 0:
            complaints.seek(0)
            said = complaints.read().decode(errors="replace").strip().splitlines()
            why = said[-1] if said else f"ffmpeg ended with {status}"
            raise OSError(why)
