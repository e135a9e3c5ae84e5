"""Pictures as files: the same bytes every time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.output import OutputError, replacing, writing
from .style import styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_METADATA: dict[str, dict[str, Any]] = {
    ".png": {},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
"""What is left out of each kind of file, so that no clock gets into it."""

FORMATS = tuple(_METADATA)


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure as the PNG, SVG or PDF that the end of `path` names.

    Text stays text in SVG and PDF. Errors as for `require_savable`.
    """
    path = Path(path)
    require_savable(path)
    with styled(), writing(path), replacing(path) as unfinished:
        figure.savefig(unfinished, metadata=_METADATA[path.suffix.lower()])


def require_savable(path: str | Path) -> None:
    """See, before any work is done for it, whether a picture can be saved at `path`.

    `ValueError` if its ending names no kind of picture, `MissingExtraError` without matplotlib,
    `OutputError` if there is no such folder.
    """
    path = Path(path)
    if path.suffix.lower() not in _METADATA:
        raise ValueError(f"{path}: the name of a picture ends in one of {', '.join(FORMATS)}")
    if not path.parent.is_dir():
        raise OutputError(f"can't write {path}: there is no folder {path.parent}")
    with styled():
        pass
