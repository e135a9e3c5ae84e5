"""A replay page in a real browser, as the tests use it."""

from __future__ import annotations

import io
import re
import time

from PIL import Image, ImageChops
from waiting import HANG


class Viewer:
    """A page in the browser, with its errors and its requests to the network."""

    def __init__(self, browser, address, **options):
        self.context = browser.new_context(**options)
        self.context.set_default_timeout(1000 * HANG)
        self.page = self.context.new_page()
        self.complaints = []
        self.requests = []
        self.page.on("console", lambda message: self._take(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(address)
        self.wait_until(lambda: not self.page.locator("body[aria-busy=true]").count())

    def _take(self, message):
        # WebGL in software has to be read back for every frame, which the driver finds slow.
        if not re.search(r"GL Driver Message \(OpenGL, Performance", message):
            self.complaints.append(message)

    def seek(self, t):
        self.page.evaluate("t => window.floorwalker.seek(t)", t)
        self.settle()

    def settle(self):
        """Wait until the requested frame is drawn."""
        self.page.evaluate(
            "() => new Promise(done => requestAnimationFrame(() => setTimeout(done)))"
        )

    def stands(self):
        """Return whether the replay shows the same time in a row of frames."""
        before = self.time
        for _ in range(5):
            self.settle()
        return self.time == before

    def wait_until(self, holds):
        """Wait until `holds` is true. The driver's own wait needs eval, which the page forbids."""
        hangs_at = time.monotonic() + HANG
        while not holds():
            assert time.monotonic() < hangs_at, "waited for what did not come"
            self.page.wait_for_timeout(20)

    def still(self, locator):
        """Return a screenshot of an element at rest: two in a row are the same."""
        shots = [locator.screenshot()]

        def same():
            shots.append(locator.screenshot())
            return shots[-1] == shots[-2]

        self.wait_until(same)
        return shots[-1]

    @property
    def time(self):
        return self.page.evaluate("window.floorwalker.time")

    def text(self, selector):
        return self.page.locator(selector).inner_text()

    def number(self, selector):
        return float(self.text(selector).split()[0].replace("−", "-"))

    def differ(self, one, other):
        """Return whether two screenshots differ by more than the smoothing of edges."""
        images = [Image.open(io.BytesIO(png)).convert("L") for png in (one, other)]
        return ImageChops.difference(*images).getextrema()[1] > 60
