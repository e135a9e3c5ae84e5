"""Formats of other tools, and the export of a run."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import cast

from floorplan import UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.problems import suggestion
from floorplan.files.values import require

from ..record.outcome import Outcome, write_trajectory
from ..record.output import OutputError, replacing, writing
from ..record.sampling import require_instants, require_rate

DEFAULT_RATE = 20.0
"""Sampling rate in Hz."""

Writer = Callable[[Outcome, Path, float], None]
"""Function that writes a run to a new file or folder at a rate in Hz."""


@dataclass(frozen=True)
class Format:
    """A format: its name and title, the suffix of its files, and its requirements.

    `parts` are the packages that its writer imports, and `extra` is the extra of Floorwalker that
    contains them. `source` is the writer as `module:function`. A format without a suffix is a
    folder.
    """

    name: str
    title: str
    suffix: str
    source: str
    parts: tuple[str, ...] = ()
    extra: str = ""

    def writer(self) -> Writer:
        """Return the function that writes it. `ValueError` if packages are missing."""
        try:
            module, _, function = self.source.partition(":")
            return cast(Writer, getattr(import_module(f".{module}", __package__), function))
        except ImportError as why:
            if (why.name or "").partition(".")[0] not in self.parts:
                raise
            raise UserError(
                f"{why.name} writes {self.title} and is missing;"
                f" pip install 'floorwalker[{self.extra}]'"
            ) from None


FORMATS = {
    entry.name: entry
    for entry in (
        Format("csv", "CSV tables", ".csv", "formats:write_csv"),
        Format(
            "parquet", "Parquet tables", ".parquet", "parquet_file:write", ("pyarrow",), "export"
        ),
        Format(
            "mcap", "MCAP files for Foxglove", ".mcap", "mcap_file:write", ("foxglove",), "export"
        ),
        Format("rosbag", "ROS 2 bags", "", "ros_bag:write", ("rosbags",), "export"),
        Format("jupedsim", "JuPedSim trajectories", ".sqlite", "jupedsim_file:write"),
    )
}


@dataclass(frozen=True)
class Export:
    """A file or folder to be written: `path`, `format`, and sampling rate (Hz)."""

    path: Path
    format: Format
    rate: float

    @classmethod
    def to(
        cls, path: str | Path, *, rate: float = DEFAULT_RATE, format: str | None = None
    ) -> Export:
        """Check the arguments of `export` before the run. The errors are the same."""
        require_rate(rate)
        path = Path(path)
        chosen = _by_name(format) if format is not None else _by_suffix(path)
        chosen.writer()
        if path.is_dir() or (path.exists() and not chosen.suffix):
            raise OutputError(f"{path} is there already; give another name, or remove it")
        return cls(path, chosen, rate)

    def write(self, run: Outcome) -> None:
        """Write `run`, or raise `OutputError` and leave nothing.

        `ValueError` if the rate is too high.
        """
        require(run, Outcome, "sim.load_run")
        require_instants(run.duration, self.rate)
        with writing(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with replacing(self.path) as unfinished:
                try:
                    self.format.writer()(run, unfinished, self.rate)
                except sqlite3.Error as why:
                    raise OSError(str(why)) from None


def write_csv(run: Outcome, path: Path, rate: float) -> None:
    """Write `run` to `path` at `rate` (Hz). See `write_trajectory`."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        write_trajectory(run, file, rate)


def export(
    run: Outcome, path: str | Path, *, rate: float = DEFAULT_RATE, format: str | None = None
) -> None:
    """Write a run to a file of another tool.

    Parameters
    ----------
    run : Run
        The run.
    path : str or Path
        File or folder. An existing file is replaced when the new one is complete. An existing
        folder is never replaced.
    rate : float, optional
        Sampling rate in Hz.
    format : str, optional
        Format. By default it depends on the suffix: .csv, .parquet, .mcap, .sqlite, or none for a
        folder with a ROS 2 bag.

    Raises
    ------
    ValueError
        If the format is unknown, the rate invalid, or a package missing.
    OutputError
        If `path` cannot be written.
    """
    Export.to(path, rate=rate, format=format).write(run)


def _by_name(name: str) -> Format:
    if name not in FORMATS:
        raise UserError(f"no format is called {name!r}; {suggestion(name, FORMATS)}")
    return FORMATS[name]


def _by_suffix(path: Path) -> Format:
    for entry in FORMATS.values():
        if path.suffix.lower() == entry.suffix:
            return entry
    ends = [f"{entry.suffix} ({entry.name})" for entry in FORMATS.values() if entry.suffix]
    raise UserError(
        f"{path}: no format ends in {path.suffix}; there are {', '.join(ends)}, and names without"
        " an ending (rosbag)"
    )
