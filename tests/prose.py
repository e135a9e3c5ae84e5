"""Sentences of pages, docstrings and comments, and their share of unclear ones.

`python -m tests.prose FOLDER...` prints the unclear sentences.
"""

import ast
import io
import re
import sys
import tokenize
from collections import Counter
from pathlib import Path

OPENING = re.compile(
    r"(Who|Whom|Whose|Whoever|Whichever|Whatever|What|That(?! is| means)|Those|Somebody|Nobody|"
    r"Everybody|One (that|who|which|alone|can|may|whose)|Of (the|these|those|two|all|several|each|"
    r"many)|Nor|Neither|Else|But)\b(?!.*\?$)"
)
"""Subjects without a noun, and conjunctions, at the begin of a sentence."""

UNCLEAR = re.compile(
    r"\b(?:some|every|no|any)body\b"
    r"|\b(?:of|past|behind|by|from|to|for|with|beside|and|but|than|as|at) (?:who|whoever)\b"
    r"|\b(?:heeds?|owes?|tells?|lets?|forgets|believes in|knows? nothing|is told)\b"
    r"|\b(?:anew|hence|(?<!thing )(?<!or )else|besides|all the same|at all|ever|alike|in vain)\b"
    r"|\b(?:stands? (?:in|for|there|by|behind)|it stands|is (?:read|asked) (?:as|for))\b"
    r"|\bof (?:one's|your|its|their|my|our) own\b"
    r"|\b(?:throng|outlook|wish(?:es)?|footing|ways? round|every thing|(?:the|of|fixed) things?)\b"
    r"|\b(?:so (?:many|long|much)(?! as\b)|a hair|that very|comes? by|go(?:es)? by|left alone"
    r"|do(?:es)? without|come(?:s)? (?:to|of) (?:it|nothing)|what (?:is|are) left)\b",
    re.I,
)
"""Words that hide the subject, the verb or the term."""

MEASURES = ("semicolons, %", "openings, %", "unclear words, ‰")


def of_page(path):
    """Yield the sentences of a Markdown page."""
    yield from sentences(path.read_text(encoding="utf-8"))


def of_module(path):
    """Yield the sentences of the docstrings and comments of a module."""
    source = path.read_text(encoding="utf-8")
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, kinds) and (text := ast.get_docstring(node)):
            # Headings, lines of parameters and examples are not sentences.
            part = r"^(\w[\w ]*\n-{3,}|[\w, *]+ : .*|(>>>|\.\.\.) .*)$"
            yield from sentences(re.sub(part, "\n", text, flags=re.M))
    block, last = [], None
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT and not re.match(
            r"#\s*(noqa|type:|ruff|mypy|fmt|pragma|!)", token.string
        ):
            if last is not None and token.start[0] > last + 1:
                yield from sentences(" ".join(block))
                block = []
            block.append(token.string.lstrip("#").strip())
            last = token.start[0]
    yield from sentences(" ".join(block))


def sentences(text):
    """Yield the sentences of a text without code, tables, headings and pictures."""
    text = re.sub(r"^(```|~~~).*?^\1\s*$", "\n", text, flags=re.M | re.S)
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)|^\|.*$|^#+ .*$|^:::.*$", "\n", text, flags=re.M)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"^( *[-*+>]|\d+\.) ", "\n", text, flags=re.M)
    for paragraph in re.split(r"\n\s*\n", text):
        plain = " ".join(re.sub(r"[*_`]{1,2}", "", paragraph).split())
        parts = re.split(r"(?<=[.!?])(?<!e\.g\.)(?<!i\.e\.)(?<!al\.) (?=[A-Z(\d])", plain)
        yield from (part for part in parts if len(part.split()) > 1)


def faults(sentence):
    """Return the number of faults of a sentence, by measure."""
    return (
        int(";" in sentence),
        int(bool(OPENING.match(sentence))),
        len(UNCLEAR.findall(sentence)),
    )


def shares(some):
    """Return the shares of faults in sentences, in the order of `MEASURES`."""
    total, words, count = Counter(), 0, 0
    for sentence in some:
        total.update(dict(enumerate(faults(sentence))))
        words += len(sentence.split())
        count += 1
    per = (100 / max(count, 1), 100 / max(count, 1), 1000 / max(words, 1))
    return tuple(round(total[k] * factor, 2) for k, factor in enumerate(per))


if __name__ == "__main__":
    for name in sys.argv[1:]:
        for file in sorted(Path(name).rglob("*.py")):
            for found in filter(lambda one: any(faults(one)), of_module(file)):
                print(f"{file}: {found}")
