"""The replay page by keyboard and for screen readers: by the rules of axe-core, if installed."""

import pytest
import replay_sample
from replay_sample import replay


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_axe_finds_no_violation(open_page, axe, scheme):
    viewer = open_page(replay.render(replay_sample.recording()), color_scheme=scheme)
    viewer.page.add_script_tag(content=axe)
    for view in ("2d", "3d"):
        viewer.page.evaluate("view => window.floorwalker.show(view)", view)
        viewer.seek(61.7)
        result = viewer.page.evaluate("axe.run(document, { resultTypes: ['violations'] })")
        assert [(v["id"], [n["html"] for n in v["nodes"]]) for v in result["violations"]] == []


def test_every_control_can_be_reached_by_the_keyboard(open_page):
    viewer = open_page(replay.render(replay_sample.recording()))
    viewer.page.locator(".events h2 button").click()  # otherwise each event is a stop
    wanted = viewer.page.evaluate(
        """() => [...document.querySelectorAll("button, select, [tabindex='0']")]
            .filter(e => e.checkVisibility({ visibilityProperty: true })).length"""
    )
    seen = set()
    for _ in range(wanted + 5):
        viewer.page.keyboard.press("Tab")
        seen.add(
            viewer.page.evaluate(
                """() => [...document.querySelectorAll("button, select, [tabindex='0']")]
                    .indexOf(document.activeElement)"""
            )
        )
    reached = len(seen - {-1})
    assert reached == wanted
