"""`python -m fuzz READER [--cases N] [--seed N]`: feed damaged files to a reader.

With `--guided`, atheris looks for inputs that reach new code (`pip install atheris`); what follows
`--` goes to libFuzzer.
"""

from __future__ import annotations

import argparse
import faulthandler
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from functools import partial
from pathlib import Path
from random import Random

from .mutations import damaged

SLOW = 5.0
"""Seconds of CPU time from which on a case is told."""


def main() -> None:
    """Run the reader that is asked for, or all."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description=__doc__)
    parser.add_argument("reader", help="a name in readers.py, recording, or all")
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--guided", action="store_true")
    own, libfuzzer = _split(sys.argv[1:])
    asked = parser.parse_args(own)
    known = _known(guided=asked.guided)
    if asked.reader != "all" and not any(asked.reader in name for name in known):
        parser.error(f"no reader is called {asked.reader}; there are: {', '.join(known)}")
    names = list(known) if asked.reader == "all" else [n for n in known if asked.reader in n]
    crashes = 0
    for name in names:
        read, sample = known[name]
        if asked.guided:
            _guided(read, sample, libfuzzer)
        crashes += _damaged(name, read, sample, asked.cases, asked.seed)
    sys.exit(1 if crashes else 0)


def _split(arguments: list[str]) -> tuple[list[str], list[str]]:
    at = arguments.index("--") if "--" in arguments else len(arguments)
    return arguments[:at], arguments[at + 1 :]


def _known(*, guided: bool) -> dict[str, tuple[Callable[[bytes], None], bytes]]:
    if guided:
        import atheris

        with atheris.instrument_imports(include=["bdi", "floorplan", "sim", "yaml", "lark"]):
            from .readers import READERS, recording, recording_of
    else:
        from .readers import READERS, recording, recording_of
    with tempfile.TemporaryDirectory() as folder:
        files = recording_of(Path(folder) / "run")
    parts = {
        f"recording {name}": (partial(recording, files, name), data) for name, data in files.items()
    }
    return {**READERS, **parts}


def _damaged(name: str, read: Callable[[bytes], None], sample: bytes, cases: int, seed: int) -> int:
    found: dict[str, int] = {}
    begin = time.process_time()
    for case in range(cases):
        data = damaged(sample, Random(f"{seed} {case}"))
        before = time.process_time()
        faulthandler.dump_traceback_later(120, exit=True)
        try:
            read(data)
        except Exception as why:
            place = traceback.extract_tb(why.__traceback__)[-1]
            where = f"{type(why).__name__} in {place.filename}:{place.lineno}: {str(why)[:100]}"
            if where not in found:
                print(f"{name}, case {case}: {where}\n  {data[:2000]!r}")
            found[where] = found.get(where, 0) + 1
        if time.process_time() - before > SLOW:
            print(f"{name}, case {case}: {time.process_time() - before:.1f} s\n  {data[:2000]!r}")
    faulthandler.cancel_dump_traceback_later()
    seconds = time.process_time() - begin
    print(f"{name}: {cases:,} cases, {sum(found.values())} crashes, {seconds:.0f} s of CPU time")
    return len(found)


def _guided(read: Callable[[bytes], None], sample: bytes, arguments: list[str]) -> None:
    """Hand over to libFuzzer, which ends the process."""
    import atheris

    corpus = Path(tempfile.mkdtemp(prefix="corpus-"))
    (corpus / "sample").write_bytes(sample)
    atheris.Setup([sys.argv[0], str(corpus), *arguments], read)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
