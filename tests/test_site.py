"""The documents as a site: it builds without a warning and needs no network."""

import importlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import sim

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


@pytest.mark.slow
def test_the_site_builds_without_a_warning_and_needs_no_network(tmp_path):
    pytest.importorskip("mkdocs")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}  # an announcement of the theme
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    for package in ("floorplan", "navigation", "bdi", "sim"):
        reference = (tmp_path / f"api-{package}.html").read_text(encoding="utf-8")
        explained = re.findall(r'<h2 id="[\w.]*\b(\w+)"', reference)
        assert set(importlib.import_module(package).__all__) <= set(explained)
    built = list(tmp_path.rglob("*.html"))
    assert len(built) >= len(list(DOCS.glob("*.md")))
    for page in built:
        html = page.read_text(encoding="utf-8")
        for tag in re.findall(r"<(?:script|link|img|iframe)\b[^>]*>", html):
            assert not re.search(r"""(?:src|href)=["']?(?:https?:)?//""", tag), (page.name, tag)
    for style in tmp_path.rglob("*.css"):
        text = style.read_text(encoding="utf-8")
        assert not re.search(r"(?:@import|url\()\s*[\"']?(?:https?:)?//", text), style.name


@pytest.mark.slow
def test_the_pictures_equal_those_of_the_script(tmp_path):
    pytest.importorskip("matplotlib")
    subprocess.run([sys.executable, str(DOCS / "make_pictures.py"), str(tmp_path)], check=True)
    made = {path.name for path in tmp_path.iterdir()}
    script = (DOCS / "make_screens.py").read_text(encoding="utf-8")
    screens = re.findall(r'^    "([\w-]+\.png)":', script, re.M)
    scenes = [f"{name}.png" for name in re.findall(r'^    "(\w+)": [\d.]+,$', script, re.M)]
    others = {
        *screens,
        *scenes,
        "competitor.png",
        "literature.svg",
        "scaling.svg",
        "cost.svg",
        "film.gif",
    }
    assert made == {path.name for path in (DOCS / "images").iterdir()} - others


@pytest.mark.parametrize("package", ["floorplan", "navigation", "bdi", "sim"])
def test_the_tables_of_names_have_every_public_name(package):
    page = (DOCS / f"api-{package}.md").read_text(encoding="utf-8")
    rows = "\n".join(re.findall(r"^\|.*", page, re.M))
    named = set(re.findall(r"`(\w+)`", rows))
    assert named == set(importlib.import_module(package).__all__)


def test_the_gallery_has_every_scene():
    gallery = (DOCS / "gallery.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(?:floorwalker run )?(\w+)`", gallery))
    assert set(sim.builtin_trials()) <= named
