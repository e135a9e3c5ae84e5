"""The command `floorwalker`: its subcommands, and its end."""

from __future__ import annotations

import copy
import io
import os
import sys
import traceback
from typing import Annotated

import typer
from typer.models import CommandInfo

from .commands.agent import agent
from .commands.bridge import bridge
from .commands.check import check, convert, list_all
from .commands.fields import fields
from .commands.new import new
from .commands.plan import benchmark, plan
from .commands.results import app as plot, export, metrics, render
from .commands.ros2 import ros2
from .commands.run import replay, run
from .commands.search import search
from .commands.study import report, study
from .commands.terminal import put_off_while_loading, say

app = typer.Typer(
    name="floorwalker",
    help="Simulate people with intentions on factory floors, beside gantries and vehicles.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        from navigation.kernels import COMPILED

        kernels = "compiled" if COMPILED else "not compiled, slow"
        say(f"floorwalker {version('floorwalker')} (kernels {kernels})")
        raise typer.Exit


@app.callback()
def _floorwalker(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


app.command()(run)
app.command()(replay)
app.command(context_settings={"ignore_unknown_options": True})(plan)
app.add_typer(plot)
app.command()(render)
app.command()(check)
app.command()(convert)
app.command()(agent)
app.command()(benchmark)
app.command()(fields)
app.command()(study)
app.command()(search)
app.command()(report)
app.command()(bridge)
app.command()(ros2)
app.command()(metrics)
app.command()(export)
app.command(name="list")(list_all)
app.command()(new)


def _of(arguments: list[str]) -> typer.Typer:
    """Return what runs the command of these arguments: itself alone, where one begins with it.

    To work out the options of all commands takes longer than most commands.
    """
    chosen = [one for one in app.registered_commands if [_name(one)] == arguments[:1]]
    if not chosen:
        return app
    alone = copy.copy(app)
    alone.registered_commands, alone.registered_groups = chosen, []
    return alone


def _name(command: CommandInfo) -> str:
    assert command.callback is not None  # as all above have
    return command.name or command.callback.__name__


def main() -> None:
    """Run the command: exit with 1 and a sentence for a mistake of the user's, 2 for wrong usage.

    Any other error is a defect: its traceback is printed, and a line that asks to report it.
    """
    # Pydantic looks for plugins in all that is installed, of which a command uses none.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # numpy's BLAS starts a thread for each core, which first of all waits for work in a loop. No
    # array of this program is large enough for them.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a × that a terminal lacks is no failure
    try:
        with put_off_while_loading():
            _of(sys.argv[1:])(prog_name="floorwalker")
    except Exception as why:
        if _is_for_user(why):
            say(f"floorwalker: {_sentence(why)}", err=True)
        else:
            from .core.custom_code import DEFECT

            traceback.print_exception(why)
            say(f"floorwalker: this is {DEFECT} with the lines above", err=True)
        sys.exit(1)
    finally:
        _drop_unread_output()


def _drop_unread_output() -> None:
    """Discard the remaining output if the standard output takes no more.

    A reader may have closed it. A full disk is reported, unless another error was.
    """
    output, ended = sys.__stdout__, sys.exc_info()[1]
    try:
        if output is not None:
            output.flush()
    except OSError as why:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        fine = not isinstance(ended, SystemExit) or ended.code in (None, 0)
        if fine and not isinstance(why, BrokenPipeError):
            say(f"floorwalker: {_sentence(why)}", err=True)
            sys.exit(1)


def _sentence(why: Exception) -> str:
    """Return the error as the user reads it: the system's errors without their number."""
    if isinstance(why, OSError) and why.strerror:
        return f"{why.filename}: {why.strerror}" if why.filename else why.strerror
    return str(why)


def _is_for_user(why: Exception) -> bool:
    """Return True if an error is for the user: one of Floorwalker's own kinds, or the system's."""
    from .core.custom_code import is_ours

    return is_ours(why) or isinstance(why, OSError)


if __name__ == "__main__":
    main()
