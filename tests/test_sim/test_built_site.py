"""The built site in a browser: navigation, search and layout, without requests to other servers."""

import functools
import http.server
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

pytest.importorskip("material", reason="the theme of the site is not installed")

ROOT = Path(__file__).resolve().parents[2]
KINDS = ("Tutorial", "How-to guides", "Reference", "Explanation")

pytestmark = pytest.mark.slow


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of the built site."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"})
    return folder


@pytest.fixture(scope="module")
def served(folder):
    """The address of the built site on a server."""
    handler = functools.partial(Quiet, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def opened(browser, address, **options):
    """Return a page, and its requests to other servers."""
    page = browser.new_context(**options).new_page()
    elsewhere = []

    def note(request):
        if not request.url.startswith((address, "data:", "blob:")):
            elsewhere.append(request.url)

    page.on("request", note)
    return page, elsewhere


@pytest.mark.parametrize("width", [390, 1440])
def test_every_page_fits_its_window_and_makes_no_request_to_other_servers(
    browser, folder, served, width
):
    page, elsewhere = opened(browser, served, viewport={"width": width, "height": 900})
    wide = []
    for file in sorted(folder.glob("*.html")):
        page.goto(served + file.name)
        if page.evaluate("document.documentElement.scrollWidth > innerWidth"):
            wide.append(file.name)
    assert (wide, elsewhere) == ([], [])


def test_the_navigation_shows_four_kinds_of_pages_and_the_contents_of_the_page(
    browser, folder, served
):
    page, _ = opened(browser, served, viewport={"width": 1440, "height": 900})
    page.goto(served + "rules.html")
    sections = page.locator(".md-nav--primary .md-nav__item--section > .md-nav__link")
    assert set(KINDS) <= {text.strip() for text in sections.all_inner_texts()}
    links = page.locator(".md-sidebar--primary a.md-nav__link:visible")
    assert links.count() >= len(list(folder.glob("*.html"))) - 1  # without the 404 page
    assert page.locator(".md-sidebar--secondary a.md-nav__link:visible").count() > 3


@pytest.mark.parametrize("place", ["server", "disk"])
def test_the_search_finds_a_page(browser, folder, served, place):
    address = served if place == "server" else f"{folder.as_uri()}/"
    page, elsewhere = opened(browser, address, viewport={"width": 1440, "height": 900})
    page.goto(address + "index.html")
    page.locator(".md-search__input").click()
    page.keyboard.type("protective stop")
    page.locator(".md-search-result__link").first.wait_for()
    links = page.locator(".md-search-result__link").evaluate_all("all => all.map(a => a.href)")
    assert any("rules.html" in link for link in links)
    assert elsewhere == []
