"""Opening of DXF files with ezdxf, without the texts and dimensions in them."""

from __future__ import annotations

import io
from contextlib import redirect_stdout
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from .problems import FloorplanError, UserError
from .reading import require_readable

if TYPE_CHECKING:
    from ezdxf.document import Drawing

LARGEST_FILE = 64_000_000
"""Bytes: a hall that is drawn in all detail takes a few million."""

DAMAGED = (
    *(ArithmeticError, AttributeError, LookupError, RuntimeError, StopIteration),
    *(TypeError, ValueError),
)
"""Exceptions that ezdxf raises, besides its own, at a drawing that is damaged."""

TOLD = frozenset(("TEXT", "MTEXT", "POINT", "DIMENSION", "LEADER", "MULTILEADER", "TOLERANCE"))
"""Kinds of entities that need not be read: they are no shapes, and nothing hangs on them."""

_ENTITY, _HANDLE, _COMMENT = 0, 5, 999
"""Codes of tags: an entity begins, its handle, nothing."""


def open_drawing(path: Path) -> Drawing:
    """Return the drawing in the file at `path`; `FloorplanError` if there is none."""
    try:
        from ezdxf.filemanagement import readfile
        from ezdxf.lldxf.const import DXFError
    except ImportError:
        message = "DXF drawings can't be read without ezdxf; pip install 'floorwalker[floorplans]'"
        raise FloorplanError.of(path, message) from None
    require_readable(path, FloorplanError, LARGEST_FILE)
    try:
        with redirect_stdout(io.StringIO()):  # ezdxf prints some of its warnings
            try:
                return _without_texts(path)
            except (DXFError, OSError, *DAMAGED):
                return readfile(path)  # which says with the line where it is damaged
    except (DXFError, *DAMAGED) as why:
        message = f"is not a DXF drawing: {str(why) or 'it ends too early'}"
        raise FloorplanError.of(path, message) from None
    except OSError as why:
        # ezdxf says this without a system's reason of a file that it does not recognise.
        message = f"can't be read: {why.strerror}" if why.strerror else "is not a DXF drawing"
        raise FloorplanError.of(path, message) from None


class _Tag(NamedTuple):
    """A tag as ezdxf takes it from a reader of its own."""

    code: int
    value: str


def _without_texts(path: Path) -> Drawing:
    """Return the drawing in the text file at `path`; any exception if there is none."""
    from ezdxf.document import Drawing
    from ezdxf.filemanagement import dxf_file_info
    from ezdxf.lldxf.validator import is_dxf_file

    if not is_dxf_file(str(path)):
        raise UserError("is not a DXF file in text")
    encoding = dxf_file_info(path).encoding
    lines = path.read_text(encoding=encoding, errors="surrogateescape").split("\n")
    tags = lines[: len(lines) // 2 * 2]
    codes, values = _kept([int(code) for code in tags[::2]], tags[1::2])
    tag: Any = partial(tuple.__new__, _Tag)  # without a call of Python's for each
    return Drawing.load(map(tag, zip(codes, values, strict=True)))


def _kept(codes: list[int], values: list[str]) -> tuple[list[int], list[str]]:
    """Return codes and values of the tags that are read: not those of texts that have a handle.

    Entities without handles are numbered as they are read, and a floor on top of the drawing may
    name these numbers.
    """
    if _COMMENT in codes:
        kept = [k for k, code in enumerate(codes) if code != _COMMENT]
        codes, values = [codes[k] for k in kept], [values[k] for k in kept]
    begins = [k for k, code in enumerate(codes) if code == _ENTITY]
    read: tuple[list[int], list[str]] = [], []
    for begin, end in zip(begins, [*begins[1:], len(codes)], strict=True):
        entity = codes[begin:end]
        if values[begin].strip() not in TOLD or _HANDLE not in entity:
            read[0].extend(entity)
            read[1].extend(values[begin:end])
        if values[begin] == "EOF":
            break
    return read
