"""A study's table as Parquet, with its types."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ..core.output import replacing
from .table import Cell


def write_parquet(columns: Mapping[str, Sequence[Cell]], path: Path) -> bool:
    """Write `columns` to `path`; whether pyarrow was there to do it."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        return False
    arrays = {name: pyarrow.array(_alike(values)) for name, values in columns.items()}
    with replacing(path) as unfinished:
        parquet.write_table(pyarrow.table(arrays), unfinished)
    return True


def _alike(values: Sequence[Cell]) -> list[Cell]:
    """The values of a column, whole numbers as floats where others are not whole."""
    if any(isinstance(value, float) for value in values):
        return [float(value) if isinstance(value, int) else value for value in values]
    return list(values)
