"""A run as one table in Parquet: a row for every body at every time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow.parquet import ParquetWriter

from ..record.outcome import Outcome, blocks

SCHEMA = pa.schema(
    [
        pa.field("t", pa.float64(), metadata={"unit": "s"}),
        pa.field("body", pa.dictionary(pa.int32(), pa.string())),
        pa.field("x", pa.float64(), metadata={"unit": "m"}),
        pa.field("y", pa.float64(), metadata={"unit": "m"}),
        pa.field("rotation", pa.float64(), metadata={"unit": "rad"}),
        pa.field("vx", pa.float64(), metadata={"unit": "m/s"}),
        pa.field("vy", pa.float64(), metadata={"unit": "m/s"}),
    ]
)
"""The columns of `trajectory.csv`, with all of their digits."""


def write(run: Outcome, path: Path, rate: float) -> None:
    """Write `run` to `path` at `rate` (Hz). Absent bodies have no rows."""
    names = pa.array(list(run.motions), pa.string())
    about = {"trial": run.scene.trial, "floorplan": run.floorplan.name, "rate": f"{rate:g}"}
    with ParquetWriter(path, SCHEMA.with_metadata(about), compression="zstd") as writer:
        for block in blocks(run, rate):
            bodies = np.tile(np.arange(len(names), dtype=np.int32), len(block.times))
            # Bodies vary fastest: (N, B, 5) → (N · B, 5).
            tables = list(block.figures.values())
            figures = np.stack(tables, axis=1) if tables else np.empty((len(block.times), 0, 5))
            columns = [
                pa.array(np.repeat(block.times, len(names))),
                pa.DictionaryArray.from_arrays(pa.array(bodies), names),
                *map(pa.array, figures.reshape(-1, figures.shape[-1]).T),
            ]
            seen = pa.array(np.array(list(block.there.values()), dtype=bool).T.reshape(-1))
            writer.write_table(pa.table(columns, schema=SCHEMA).filter(seen))
