"""`floorwalker benchmark`: planners side by side."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..core.output import replacing, writing
from . import completion
from .consoles import plain_console, say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from floorplan import Floorplan
    from navigation.benchmark import Attempt, Row


def benchmark(
    floorplan: Annotated[
        list[str] | None,
        typer.Option(
            help="A built-in name or a file; again for more. All built-in by default.",
            autocompletion=completion.floor,
        ),
    ] = None,
    planner: Annotated[
        list[str] | None,
        typer.Option(
            help="A planner's name; again for more. All by default.",
            autocompletion=completion.planner,
        ),
    ] = None,
    queries: Annotated[int, typer.Option(min=1, help="Questions on each floor.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Of the questions and the planners.")] = 0,
    radius: Annotated[
        float | None, typer.Option(help="Of the person, in metres; the floor's own by default.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="A folder for CSV, OMPL benchmark logs and plots.")
    ] = None,
) -> None:
    """Measure planners: CPU time, checks, length against the shortest path, clearance, turning."""
    import floorplan as floors
    from navigation import planners
    from navigation.benchmark import summary

    known = [info.name for info in planners()]
    names = list(dict.fromkeys(planner or known))
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ValueError(f"no planner is called {unknown[0]!r}; there are: {', '.join(known)}")
    plans = [floors.load(source) for source in floorplan or floors.builtin()]
    if out is not None:
        with writing(out):
            out.mkdir(parents=True, exist_ok=True)
    attempts = _measure(plans, names, queries, seed, radius)
    _print_table(summary(attempts))
    if out is not None:
        with writing(out):
            _write(attempts, out, seed)


def _measure(
    plans: Sequence[Floorplan], names: list[str], queries: int, seed: int, radius: float | None
) -> list[Attempt]:
    from rich.markup import escape

    from navigation.benchmark import benchmark as measure
    from sim.commands.bars import progress_bars

    with progress_bars() as bar:
        task = bar.add_task("", total=len(plans) * len(names) * queries)

        def progress(floor: str, name: str) -> None:
            bar.update(task, advance=1, description=escape(f"{floor}: {name}"))

        return measure(plans, names, queries=queries, seed=seed, radius=radius, progress=progress)


def _print_table(rows: Sequence[Row]) -> None:
    from rich.table import Table

    table = Table("floor", "planner")
    for title in (
        "solved",
        "CPU ms\nmedian",
        "CPU ms\n99 %",
        "checks\nmedian",
        "length ÷\nshortest",
        "\nat most",
        "clear\nm, least",
        "turning\nrad",
    ):
        table.add_column(title, justify="right")
    for row in rows:
        table.add_row(
            row.floorplan,
            row.planner,
            f"{row.solved:.0%}",
            f"{row.cpu_median:.2f}",
            f"{row.cpu_99:.2f}",
            f"{row.checks:.0f}",
            f"{row.ratio_median:.4f}",
            f"{row.ratio_most:.4f}",
            f"{row.clearance_least:.4f}",
            f"{row.turning:.2f}",
        )
    plain_console(120).print(table)


def _write(attempts: Sequence[Attempt], out: Path, seed: int) -> None:
    from navigation.benchmark import write_csv, write_ompl_log

    with replacing(out / "benchmark.csv") as unfinished:
        write_csv(attempts, unfinished)
    floors = list(dict.fromkeys(attempt.floorplan for attempt in attempts))
    for floor in floors:
        there = [attempt for attempt in attempts if attempt.floorplan == floor]
        with replacing(out / f"{floor}.log") as unfinished:
            write_ompl_log(there, unfinished, seed=seed)
        _plot(there, out / f"{floor}.png")
    say(f"wrote {out}/benchmark.csv and a log for each floor", err=True)


def _plot(attempts: Sequence[Attempt], path: Path) -> None:
    """Draw box plots, where matplotlib is there."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        return
    names = list(dict.fromkeys(attempt.planner for attempt in attempts))
    figure = Figure(figsize=(9, 8), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    above.boxplot([[1000 * a.cpu_seconds for a in attempts if a.planner == n] for n in names])
    above.set(yscale="log", ylabel="CPU time (ms)", title=attempts[0].floorplan)
    below.boxplot([[a.ratio for a in attempts if a.planner == n and a.solved] for n in names])
    below.set(ylabel="length ÷ shortest", xticks=range(1, len(names) + 1))
    below.set_xticklabels(names, rotation=45, ha="right")
    with replacing(path) as unfinished:
        figure.savefig(unfinished)
