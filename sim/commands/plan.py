"""`floorwalker plan` and `floorwalker benchmark`."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..record.output import replacing, writing
from .arguments import (
    Coordinate,
    GoalX,
    Radius,
    StartX,
    complete_contender,
    complete_floor,
    complete_planner,
    complete_questions,
)
from .terminal import plain_console, progress_bars, say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from floorplan import Floorplan
    from navigation import CollisionWorld, Path as PlannedPath
    from navigation.benchmark import Attempt, PlannerRow
    from navigation.catalog import PlannerChoice


def plan(
    floorplan: Annotated[
        str,
        typer.Argument(help="Floorplan: a name or a file.", autocompletion=complete_floor),
    ],
    x0: StartX,
    y0: Coordinate,
    x1: GoalX,
    y1: Coordinate,
    planner: Annotated[
        str | None,
        typer.Option(
            help='Name (see `floorwalker list`) or "BITstar: {samples_per_batch: 50}".',
            autocompletion=complete_planner,
        ),
    ] = None,
    radius: Radius = None,
    agv: Annotated[
        list[str] | None,
        typer.Option(help="NAME=PLACE: location or lane position of an AGV; repeat for more."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Random seed of sampling planners.")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print the path as JSON.")] = False,
    plot: Annotated[
        Path | None, typer.Option(help="Draw floor and path to this PNG, SVG or PDF file.")
    ] = None,
) -> None:
    """Plan a person's path from (X0, Y0) to (X1, Y1), in metres."""
    import time

    import floorplan as floors
    import navigation
    from navigation.catalog import PlannerChoice

    from ..core.custom_code import CodeFolder
    from ..people.programs import find_planner

    world = navigation.CollisionWorld(floors.load(floorplan))
    for text in agv or ():
        _move(world, text)
    choice = PlannerChoice() if planner is None else PlannerChoice.of(planner)
    seeker = navigation.PathPlanner(world, radius, planner=find_planner(choice, CodeFolder()))
    begin = time.process_time()
    planned = seeker.plan((x0, y0), (x1, y1), seed=seed)
    cpu_seconds = time.process_time() - begin
    if plot is not None:
        _draw(world, planned, seeker.radius, plot)
    say(_as_json(planned, cpu_seconds) if json else _path_in_words(planned, cpu_seconds))


def _move(world: CollisionWorld, text: str) -> None:
    """Move an AGV to the place of NAME=PLACE, a location or a lane position."""
    from floorplan import UserError

    name, equals, place = text.partition("=")
    if not (name and equals and place):
        raise typer.BadParameter(f"expected NAME=PLACE, found {text!r}", param_hint="--agv")
    to: str | float = place
    with suppress(ValueError):
        to = float(place)
    try:
        world.move_agv(name, to)
    except KeyError as why:
        raise UserError(why.args[0]) from None


def _path_in_words(planned: PlannedPath, cpu_seconds: float) -> str:
    lines = [
        f"{planned.planner}: length {planned.length:.3f} m, clearance {planned.clearance:.3f} m,"
        f" {1000 * cpu_seconds:.1f} ms"
    ]
    lines += [f"  {x:9.3f} {y:9.3f}" for x, y in planned.points]
    return "\n".join(lines)


def _as_json(planned: PlannedPath, cpu_seconds: float) -> str:
    import json

    return json.dumps(
        {
            "points": planned.points.tolist(),
            "length": planned.length,
            "clearance": planned.clearance,
            "planner": planned.planner,
            "cpu_seconds": cpu_seconds,
        }
    )


def _draw(world: CollisionWorld, planned: PlannedPath, radius: float, path: Path) -> None:
    from ..views import plots

    plots.save(plots.path(world, planned, radius=radius), path)


_ODD = r"[^\w.-]"
"""Characters of names that are not used in file names."""

QUERIES = 20
"""Default number of seeded queries."""


def benchmark(
    floorplan: Annotated[
        list[str] | None,
        typer.Option(
            help="Floorplan: a name or a file; repeat for more (default: all built-in ones, or the"
            " map of the queries).",
            autocompletion=complete_floor,
        ),
    ] = None,
    planner: Annotated[
        list[str] | None,
        typer.Option(
            help="Planner: a name or 'NAME: {parameter: value}'; repeat for more (default: all)."
            " Planners of other packages: JuPedSim, extremitypathfinder, pyastar2d, scikit-image,"
            " and PRM-of-corners, a roadmap of OMPL.",
            autocompletion=complete_contender,
        ),
    ] = None,
    queries: Annotated[
        int | None,
        typer.Option(min=1, help="Queries on each floor (default: 20, or all in the file)."),
    ] = None,
    questions: Annotated[
        Path | None,
        typer.Option(
            help="Queries: CSV file (x0, y0, x1, y1, AGVs) or MovingAI .scen file.",
            autocompletion=complete_questions,
        ),
    ] = None,
    runs: Annotated[int, typer.Option(min=1, help="Repetitions of each query.")] = 1,
    iterations: Annotated[
        int | None,
        typer.Option(min=1, help="Iteration budget of OMPL planners (default: per planner)."),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(help="CPU time budget of OMPL planners per query; results then vary."),
    ] = None,
    longest: Annotated[
        float | None,
        typer.Option(help="Maximum length, as a multiple of the shortest; longer paths are wrong."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Random seed of queries and planners.")] = 0,
    radius: Radius = None,
    cell: Annotated[
        float | None, typer.Option(help="Cell size of a MovingAI map in metres (default: 1).")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for CSV files, OMPL benchmark logs and a report.")
    ] = None,
) -> None:
    """Benchmark planners: success, CPU time, length, clearance and memory."""
    from navigation import planners
    from navigation.benchmark import benchmark as measure, summary, table_name

    from ..core.compilation import notice_uncompiled

    notice_uncompiled()
    for name, figure in (("--seconds", seconds), ("--longest", longest), ("--radius", radius)):
        least = 1.0 if name == "--longest" else 0.0
        if figure is not None and not (least < figure < math.inf):
            wrong = f"must be above {least:g} and finite, found {figure:g}"
            raise typer.BadParameter(wrong, param_hint=name)
    contenders = {
        table_name(one): one for one in map(_planner, planner or [i.name for i in planners()])
    }
    names = list(contenders)
    plans = _floors(floorplan, questions, cell)
    if questions is None:
        queries = queries or QUERIES
    if out is not None:
        with writing(out):
            out.mkdir(parents=True, exist_ok=True)
    total = None if queries is None else len(plans) * len(names) * queries * runs
    with progress_bars() as bar:
        from rich.markup import escape

        task = bar.add_task("", total=total)

        def progress(floor: str, name: str) -> None:
            bar.update(task, advance=1, description=escape(f"{floor}: {name}"))

        attempts = measure(
            plans,
            list(contenders.values()),
            queries=queries,
            runs=runs,
            seed=seed,
            radius=radius,
            questions=questions,
            iterations=iterations,
            seconds=seconds,
            longest=longest,
            progress=progress,
        )
    rows = summary(attempts)
    _print_tables(rows)
    _warn_of_unknown(attempts, longest)
    if seconds is not None:
        say("warning: with --seconds, results depend on the machine", err=True)
    if out is None:
        return
    terms = {
        "planners": ", ".join(names),
        "queries": _queries_in_words(rows, questions, seed),
        "runs": f"{runs} of each query",
        "radius": ", ".join(
            f"{plan.human.radius if radius is None else radius:g} m on {plan.name}"
            for plan in plans
        ),
        "budget": _budget(iterations, seconds),
        "longest allowed": "any" if longest is None else f"{longest:g} × the shortest",
    }
    with writing(out):
        _write(attempts, rows, plans, out, seed, seconds, terms)


def _warn_of_unknown(attempts: Sequence[Attempt], longest: float | None) -> None:
    """Print the floors without comparable lengths, which `--longest` cannot judge."""
    from navigation.benchmark import MOST_CORNERS

    unjudged = "" if longest is None else "; --longest ignores these"
    for floor in dict.fromkeys(attempt.asked.floorplan for attempt in attempts):
        shortest = {a.asked.query: a.asked.shortest for a in attempts if a.asked.floorplan == floor}
        if unknown := sum(math.isnan(length) for length in shortest.values()):
            say(
                f"{floor}: the shortest length of {unknown} of {len(shortest)} queries is unknown,"
                f" because the floor has more than {MOST_CORNERS:,} corners{unjudged}",
                err=True,
            )


def _planner(text: str) -> str | PlannerChoice:
    """Return the peer or the planner of that name. A custom one is imported from here."""
    from floorplan import UserError
    from navigation import planners
    from navigation.benchmark import PEERS
    from navigation.catalog import PlannerChoice

    from ..core.custom_code import CodeFolder
    from ..people.programs import find_planner

    if text in PEERS:
        return text
    choice = None
    try:
        choice = PlannerChoice.of(text)
        return find_planner(choice, CodeFolder())
    except UserError as why:
        names = [info.name for info in planners()]
        unknown = choice is not None and not choice.is_own and choice.name not in names
        others = f" (peers: {', '.join(PEERS)})" if unknown else ""
        raise UserError(f"--planner {text}: {why}{others}") from None


def _floors(
    floorplan: list[str] | None, questions: Path | None, cell: float | None
) -> list[Floorplan]:
    """Return the floors of the benchmark. For a scenario without a floor it is its map."""
    import floorplan as floors
    from floorplan.formats.movingai import CELL
    from navigation.benchmark import map_of

    sources: list[str] = list(floorplan or [])
    if questions is not None and not sources:
        if questions.suffix.lower() != ".scen":
            raise floors.UserError(f"--questions {questions} needs --floorplan")
        sources = [str(map_of(questions))]
    maps = [source for source in sources if source.lower().endswith(".map")]
    if cell is not None and not maps:
        raise floors.UserError(f"--cell {cell:g} needs a MovingAI map")
    return [
        floors.load_movingai(Path(source), CELL if cell is None else cell)
        if source in maps
        else floors.load(source)
        for source in sources or floors.builtin()
    ]


def _queries_in_words(rows: Sequence[PlannerRow], questions: Path | None, seed: int) -> str:
    counts = ", ".join(
        f"{count} on {floor}" for floor, count in {r.floorplan: r.queries for r in rows}.items()
    )
    return f"{counts}; {f'from {questions.name}' if questions else 'random'}, seed {seed}"


def _budget(iterations: int | None, seconds: float | None) -> str:
    words = [] if iterations is None else [f"{iterations:,} iterations"]
    words += [] if seconds is None else [f"{seconds:g} s of CPU time"]
    return " or ".join(words) or "iterations, per planner"


def _print_tables(rows: Sequence[PlannerRow]) -> None:
    """Print a table for each floor."""
    from rich.table import Table

    with_listed = any(not math.isnan(row.listed_ratio.value) for row in rows)
    for floor in dict.fromkeys(row.floorplan for row in rows):
        table = Table(title=floor)
        table.add_column("planner", overflow="fold")
        for title in (
            "solved\n(95 % CI)",
            "wrong",
            "CPU ms\nmedian",
            "\n99 %",
            "length ÷\nshortest",
            "\nat most",
            *(["÷ listed\nmedian"] if with_listed else []),
            "min. clear-\nance m",
            "turning\nrad",
        ):
            table.add_column(title, justify="right", no_wrap=True)
        for row in rows:
            if row.floorplan == floor:
                table.add_row(*_cells(row, with_listed))
        plain_console(120).print(table)


def _cells(row: PlannerRow, with_listed: bool) -> list[str]:
    return [
        row.planner,
        f"{row.solved.value:.0%}\n{row.solved.low:.0%}–{row.solved.high:.0%}",
        str(row.wrong),
        f"{row.cpu.value:.2f}{_spread(row)}",
        f"{row.cpu_99:.2f}",
        _figure(row.ratio.value, 4),
        _figure(row.ratio_most, 4),
        *([_figure(row.listed_ratio.value, 4)] if with_listed else []),
        _figure(row.clearance_least, 4),
        _figure(row.turning, 2),
    ]


def _figure(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "–"


def _spread(row: PlannerRow) -> str:
    return f"\n{row.cpu.low:.2f}–{row.cpu.high:.2f}" if math.isfinite(row.cpu.low) else ""


def _write(
    attempts: Sequence[Attempt],
    rows: Sequence[PlannerRow],
    plans: Sequence[Floorplan],
    out: Path,
    seed: int,
    seconds: float | None,
    terms: dict[str, str],
) -> None:
    from navigation.benchmark import write_csv, write_ompl_log, write_summary

    from ..views.benchmark_page import write_page

    with replacing(out / "benchmark.csv") as unfinished:
        write_csv(attempts, unfinished)
    with replacing(out / "summary.csv") as unfinished:
        write_summary(rows, unfinished)
    for plan in plans:
        there = [attempt for attempt in attempts if attempt.asked.floorplan == plan.name]
        with replacing(out / f"{re.sub(_ODD, '_', plan.name)}.log") as unfinished:
            write_ompl_log(there, unfinished, seed=seed, seconds=seconds)
    write_page(attempts, plans, out / "report.html", terms=terms, on_the_clock=seconds is not None)
    say(
        f"Wrote {out}/report.html, CSV files of all answers and an OMPL log for each floor",
        err=True,
    )
