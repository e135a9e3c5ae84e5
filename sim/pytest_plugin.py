"""Floorwalker in pytest: trial files as tests, fixtures that run trials, markers that vary them.

A file `*.trial.yaml` that expects something is a test. Nothing but pytest is imported here, so that
test suites which have nothing to do with Floorwalker lose no time.
"""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from types import FunctionType, GeneratorType
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from sim import Run, Trial

    from .testing.trial_items import Failures
    from .testing.variations import Variation

_MARKERS = (
    "trials(file, ...): run the test once for each trial, by file or by built-in name",
    "personalities(name, ...): give all people each personality; 'all' for all built-in ones",
    "controllers(name, ...): give the gantry each controller; 'all' for all built-in ones",
    "rule_sets(name, ...): apply each rule set; 'all' for all built-in ones",
    "seeds(seed, ...): run with each seed; also seeds(range(10))",
)

_NAMES = tuple(marker.partition("(")[0] for marker in _MARKERS)

_FAILURES: pytest.StashKey[Failures] = pytest.StashKey()
"""Where a test has what its runs left."""

REPEAT = "floorwalker_repeat"
"""Property of the report of a test with seeds; see `repeat_of`."""

_CELL = """
name: ariac_cell
floorplan: ariac2023
duration: 120.0
people: [{name: operator}]
gantry:
  controller: oblivious
  repeat: true
  jobs:
    - {pick: bin2, place: agv1, part: purple pump}
    - {pick: bin6, place: agv4, part: blue battery}
"""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options that say where replay pages go, and what trials may name."""
    group = parser.getgroup("floorwalker")
    group.addoption(
        "--floorwalker-replays",
        metavar="DIR",
        help="keep the replay pages of trials that failed in this folder",
    )
    group.addoption(
        "--no-own-code",
        action="store_true",
        help="reject custom Python code such as laws and controllers",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Make the markers known."""
    for marker in _MARKERS:
        config.addinivalue_line("markers", marker)


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Take a trial file that expects something as a test."""
    if not file_path.name.endswith(".trial.yaml"):
        return None
    from .testing.trial_items import TrialFile

    return TrialFile.from_parent(parent, path=file_path)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Vary the trial of a test as its markers say."""
    if any(metafunc.definition.get_closest_marker(name) for name in _NAMES):
        from .testing.variations import vary

        vary(metafunc)


def pytest_pycollect_makeitem(collector: pytest.Module | pytest.Class, name: str, obj: Any) -> None:
    """Refuse a marker that has marked the one controller it gives, in place of the test.

    pytest takes a marker that is called with one function alone for that function's decorator.
    """
    kind = type(obj)  # and not isinstance, which some objects of test modules don't bear
    given: list[str] = []
    if collector.funcnamefilter(name) or collector.classnamefilter(name):
        given = ["controllers"] if kind is GeneratorType else []
    elif issubclass(kind, FunctionType | type):
        given = [mark.name for mark in getattr(obj, "pytestmark", []) if not mark.args]
    for marker in {*given} & {*_NAMES}:
        raise collector.CollectError(
            f"@pytest.mark.{marker} was called with one function alone, which pytest takes for the"
            f" test: write @pytest.mark.{marker}.with_args(...)"
        )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add the results of the trials to the report of a failed test."""
    report = yield
    failures = item.stash.get(_FAILURES, None)
    if failures is not None and failures.runs:
        if report.failed and report.when != "teardown":
            report.sections.append(("Floorwalker", failures.report()))
        if report.when == "call" and item.get_closest_marker("seeds") is not None:
            from .testing.repeats import repeat_of

            # A property also comes back from the processes of pytest-xdist.
            report.user_properties.append((REPEAT, repeat_of(item, failures.runs)))
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Report tests whose runs are identical with all their seeds."""
    repeats = {
        report.nodeid: value
        for found in terminalreporter.stats.values()
        for report in found
        if isinstance(report, pytest.TestReport)
        for name, value in report.user_properties
        if name == REPEAT
    }
    if repeats:
        from .testing.repeats import identical_repeats

        if lines := [*identical_repeats(repeats.values())]:
            terminalreporter.section("Floorwalker")
            for line in lines:
                terminalreporter.line(line)


@pytest.fixture
def ariac_cell(request: pytest.FixtureRequest) -> Trial:
    """Return a trial of 120 s on the ARIAC 2023 floor with an operator and a working gantry."""
    from .trials.trial import Trial

    own_code = _own_code(request.config)
    folder = request.path.parent
    return Trial.parse(_CELL, file="ariac_cell", folder=folder, own_code=own_code)


@pytest.fixture
def trial(ariac_cell: Trial, _floorwalker_variation: Variation | None) -> Trial:
    """Return the trial of this test: `ariac_cell`, changed by the markers of the test."""
    variation = _floorwalker_variation
    return ariac_cell if variation is None else variation.of(variation.trial or ariac_cell)


@pytest.fixture
def run_trial(
    trial: Trial,
    request: pytest.FixtureRequest,
    _floorwalker_variation: Variation | None,
    _floorwalker_failures: Failures,
) -> Callable[..., Run]:
    """Run a trial, `run_trial()`: the one of this test, another one, or one in a file.

    A file is relative to that of the test, and a name is that of a built-in trial. Both are varied
    by the markers of the test. A `Trial` runs unchanged. If the test fails, the report has what its
    runs came to, and where their replay pages are.
    """

    def run(chosen: Trial | str | Path = trial) -> Run:
        from .testing.variations import find_trial
        from .trials.trial import Trial

        __tracebackhide__ = True
        if not isinstance(chosen, Trial):
            own_code = _own_code(request.config)
            chosen = find_trial(chosen, request.path.parent, own_code=own_code)
            if _floorwalker_variation is not None:
                chosen = _floorwalker_variation.of(chosen)
        return _floorwalker_failures.run(chosen)

    return run


def _own_code(config: pytest.Config) -> bool:
    """Return False if trials may name no Python of the user's own."""
    return not config.getoption("--no-own-code")


@pytest.fixture
def _floorwalker_variation(request: pytest.FixtureRequest) -> Variation | None:
    return getattr(request, "param", None)


@pytest.fixture
def _floorwalker_failures(request: pytest.FixtureRequest) -> Failures:
    from .testing.trial_items import Failures

    failures = request.node.stash[_FAILURES] = Failures(request.node)
    return failures
