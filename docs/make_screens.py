"""Makes the film and the screenshots in the documents: `python docs/make_screens.py [FOLDER]`.

It needs the extra `film` and Chromium. The drawings depend on the browser and the fonts, so that
these pictures, unlike those of `make_pictures.py`, are not the same to the byte everywhere.
"""

from __future__ import annotations

import io
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import Browser

import sim
from sim.views.film import in_browser, render as render_film
from sim.views.replay import render
from sim.views.replay_data import replay_data

DOCS = Path(__file__).resolve().parent
FILM = "film.gif"


@dataclass(frozen=True, kw_only=True)
class Screen:
    """A picture of the page of a trial, or of two that differ in their controller."""

    trial: str
    at: float
    view: str = "2d"
    controllers: tuple[str, ...] = ()
    follow: str = ""
    turn: tuple[int, int] = (0, 0)
    """The drag with the mouse, pixels."""
    nearer: float = 0.0
    """The turn of the wheel."""
    dark: bool = False
    size: tuple[int, int] = (1400, 860)
    whole_page: bool = True
    """False for the floor alone."""


TWO_PEOPLE = str(DOCS.parent / "examples" / "two_people.trial.yaml")
VEHICLES = str(DOCS.parent / "examples" / "vehicles.trial.yaml")
SCREENS = {
    "vehicles.png": Screen(trial=VEHICLES, at=52.0, size=(1400, 780)),
    "replay.png": Screen(trial="workcell", at=47.0),
    "space.png": Screen(trial="workcell", at=57.5, view="3d", nearer=-330.0, size=(1400, 780)),
    "space-dark.png": Screen(
        trial=TWO_PEOPLE, at=84.0, view="3d", follow="ben", turn=(-90, -40), dark=True
    ),
    "space-eyes.png": Screen(trial=TWO_PEOPLE, at=33.0, view="eyes"),
    "compared.png": Screen(
        trial="workcell", at=90.0, view="3d", controllers=("oblivious", "avoiding")
    ),
}

SCENES = {
    "people_aisle": 7.5,
    "people_blind_spot": 5.0,
    "people_bottleneck": 6.5,
    "people_corner": 5.5,
    "people_counterflow": 8.5,
    "people_crossing": 6.0,
    "people_door": 9.0,
    "people_frontal": 7.5,
    "people_group": 6.5,
    "people_overtaking": 9.0,
    "people_parallel": 8.0,
    "people_perpendicular": 6.5,
    "people_queue": 24.0,
    "vehicles_corridor": 9.0,
    "vehicles_crossing": 41.0,
    "vehicles_dock": 60.0,
    "vehicles_lift": 40.0,
    "vehicles_warehouse": 60.0,
    "scene_antagonistic": 17.0,
    "scene_helpful": 14.0,
    "scene_indifferent": 16.0,
}
"""The scenes among the built-in trials, and an instant of each (seconds)."""

SCREENS |= {
    f"{name}.png": Screen(trial=name, at=at, view="3d", size=(860, 760), whole_page=False)
    for name, at in SCENES.items()
}


def page_of(screen: Screen) -> str:
    """Return the replay page that a screen shows."""
    trial = sim.Trial.load(screen.trial)
    recordings = []
    for controller in screen.controllers or [trial.gantry.controller]:
        changed = replace(trial, gantry=replace(trial.gantry, controller=controller))
        with TemporaryDirectory() as folder:
            recording = sim.Recording(Path(folder))
            recording.finish(sim.run(changed, recording))
            recordings.append(replay_data(sim.load_run(folder)) | {"folder": str(controller)})
    return render(*recordings)


def shoot(browser: Browser, screen: Screen, file: Path) -> None:
    """Write one picture to `file`."""
    with TemporaryDirectory() as folder:
        page_file = Path(folder) / "page.html"
        page_file.write_text(page_of(screen), encoding="utf-8")
        width, height = screen.size
        context = browser.new_context(
            viewport={"width": width, "height": height},
            color_scheme="dark" if screen.dark else "light",
        )
        page = context.new_page()
        page.goto(f"{page_file.as_uri()}#t={screen.at}&view={screen.view}")
        if screen.follow:
            page.locator("#follow").select_option(screen.follow)
        box = page.locator("#views").bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] * 0.52, box["y"] + box["height"] * 0.5
        page.mouse.move(x, y)
        if screen.nearer:
            page.mouse.wheel(0, screen.nearer)
        if screen.turn != (0, 0):
            page.mouse.down()
            page.mouse.move(x + screen.turn[0], y + screen.turn[1], steps=4)
            page.mouse.up()
        page.mouse.move(0, 0)
        page.wait_for_timeout(500)
        clip = None if screen.whole_page else page.locator("#views").bounding_box()
        png = page.screenshot(timeout=120_000, clip=clip)
        context.close()
    Image.open(io.BytesIO(png)).convert("RGB").quantize(256 if screen.whole_page else 96).save(
        file, optimize=True
    )


def main(folder: Path, names: list[str]) -> None:
    """Write the pictures of those names into `folder`, or all."""
    names = names or [*SCREENS, FILM]

    def shoot_all(browser: Browser) -> None:
        for name in names:
            if name != FILM:
                shoot(browser, SCREENS[name], folder / name)

    in_browser("a screenshot", shoot_all)
    if FILM in names:
        run = sim.run(sim.Trial.load("workcell"))
        render_film(run, folder / FILM, speed=6.0, fps=6, width=440, within=(0.0, 60.0))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS / "images", sys.argv[2:])
