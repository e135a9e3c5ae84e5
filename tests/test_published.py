"""All tables and pictures that `nox -s published` recreates, identical on every machine."""

import re
import shutil
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"

OF_THE_MACHINE = {"scaling.svg", "cost.svg", "film.gif"}
"""Pictures of CPU times, and pictures drawn by a browser."""


@pytest.fixture
def published(monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.syspath_prepend(DOCS)
    return import_module("published")


def test_every_marked_table_is_made_and_has_one_place(published):
    made = [name for one in published.PUBLISHED.values() for name in one.tables]
    marked = [
        name
        for page in sorted(DOCS.glob("*.md"))
        for name in re.findall(r"<!-- table: (\w+) -->\n", page.read_text(encoding="utf-8"))
    ]
    assert sorted(marked) == sorted(made)


def test_all_pictures_except_those_of_a_browser_or_of_times_are_made(published):
    made = [name for one in published.PUBLISHED.values() for name in one.pictures]
    screens = set(re.findall(r'^    "([\w-]+\.png)":', _screens(), re.M))
    screens |= {f"{name}.png" for name in re.findall(r'^    "(\w+)": [\d.]+,$', _screens(), re.M)}
    assert {*made} == {path.name for path in (DOCS / "images").iterdir()} - screens - OF_THE_MACHINE
    assert len({*made}) == len(made)


def _screens():
    return (DOCS / "make_screens.py").read_text(encoding="utf-8")


def test_a_table_that_differs_is_named_and_repaired(published, tmp_path, monkeypatch, capsys):
    page = Path(shutil.copy(DOCS / "recordings.md", tmp_path))
    right = page.read_text(encoding="utf-8")
    page.write_text(right.replace("| `penalties` |", "| `penances` |"), encoding="utf-8")
    monkeypatch.setattr(published, "DOCS", tmp_path)
    assert published.publish(["reference"]) == ["docs/recordings.md: table figures"]
    assert page.read_text(encoding="utf-8") == right
    assert published.publish(["reference"]) == []
    assert capsys.readouterr().out.startswith("reference: ")


def test_a_picture_that_differs_is_named_and_repaired(published, tmp_path, monkeypatch):
    (tmp_path / "images").mkdir()
    there = Path(shutil.copy(DOCS / "images" / "plot-path.svg", tmp_path / "images"))
    right = there.read_bytes()
    one = published.Published(
        lambda out: bool((out / "plot-path.svg").write_bytes(right)) and {},
        pictures=("plot-path.svg",),
    )
    monkeypatch.setitem(published.PUBLISHED, "one", one)
    monkeypatch.setattr(published, "DOCS", tmp_path)
    assert published.publish(["one"]) == []
    there.write_bytes(right.replace(b"<path", b"<line", 1))
    assert published.publish(["one"]) == ["docs/images/plot-path.svg"]
    assert there.read_bytes() == right


def test_invisible_changes_are_no_difference(published, tmp_path):
    from PIL import Image

    one, other = tmp_path / "one.svg", tmp_path / "other.svg"
    one.write_text('<path d="M 10.001 5" id="m1a2"/>')
    for text, same in (
        ('<path d="M 10.0001 5.01" id="m1a2"/>', True),
        ('<path d="M 10.1 5" id="m1a2"/>', False),
        ('<path d="M 10.001 5" id="m1a3"/>', False),
        ('<path d="M 10.001 5 6" id="m1a2"/>', False),
    ):
        other.write_text(text)
        assert published.differ(one, other) is not same
    one, other = tmp_path / "one.png", tmp_path / "other.png"
    image = Image.new("RGB", (100, 100), (200, 200, 200))
    image.save(one)
    for box, shade, same in (
        ((0, 0, 100, 100), 204, True),
        ((0, 0, 2, 4), 0, True),
        ((0, 0, 5, 5), 0, False),
    ):
        changed = image.copy()
        changed.paste((shade, shade, shade), box)
        changed.save(other)
        assert published.differ(one, other) is not same
    image.resize((99, 100)).save(other)
    assert published.differ(one, other)


def test_an_unknown_name_is_rejected(published, monkeypatch):
    monkeypatch.setattr("sys.argv", ["published.py", "path"])
    with pytest.raises(SystemExit, match="nothing is called 'path'; there are: reference, "):
        published.main()
