"""`python -m fuzz READER [--cases N] [--first N] [--seed N]`: feed damaged files to a reader.

With `--guided`, atheris looks for inputs that reach new code (`pip install atheris`); what follows
`--` goes to libFuzzer.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING

from .hunt import hunt
from .mutations import damaged

if TYPE_CHECKING:
    from .readers import Reader


def main() -> None:
    """Run the reader that is asked for, or all."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description=__doc__)
    parser.add_argument("reader", help="a name in readers.py, or all")
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--guided", action="store_true")
    own, libfuzzer = _split(sys.argv[1:])
    asked = parser.parse_args(own)
    if asked.guided:
        import atheris

        with atheris.instrument_imports(include=["bdi", "floorplan", "sim", "yaml", "lark"]):
            from .readers import READERS
    else:
        from .readers import READERS
    if asked.reader not in ("all", *READERS):
        parser.error(f"no reader is called {asked.reader}; there are: {', '.join(READERS)}")
    chosen = [asked.reader] if asked.reader in READERS else list(READERS)
    if asked.guided:
        _guided(READERS[chosen[0]], libfuzzer)
    cases = range(asked.first, asked.first + asked.cases)
    found = [hunt(name, READERS[name], cases, asked.seed) for name in chosen]
    sys.exit(1 if any(found) else 0)


def _split(arguments: list[str]) -> tuple[list[str], list[str]]:
    at = arguments.index("--") if "--" in arguments else len(arguments)
    return arguments[:at], arguments[at + 1 :]


def _guided(reader: Reader, arguments: list[str]) -> None:
    """Hand over to libFuzzer, which ends the process; files are damaged as elsewhere."""
    import atheris

    def damage(data: bytes, most: int, seed: int) -> bytes:
        return damaged(data, Random(seed), reader.form)[:most]

    corpus = Path(tempfile.mkdtemp(prefix="corpus-"))
    for number, sample in enumerate(reader.samples()):
        (corpus / f"sample{number}").write_bytes(sample)
    atheris.Setup([sys.argv[0], str(corpus), *arguments], reader.read, custom_mutator=damage)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
