"""The pages about AgentSpeak, compared with what their examples print."""

import json
import re
from pathlib import Path

import bdi

DOCS = Path(__file__).parents[2] / "docs"


def blocks(page, language):
    """Return the code blocks of a page in a language ("" for AgentSpeak and scripts)."""
    text = (DOCS / page).read_text(encoding="utf-8")
    fenced = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.M | re.S)
    return [block for kind, block in fenced if kind == language]


def entries(console):
    return [json.loads(line) for line in console.splitlines() if line.startswith("{")]


def run(program, script=(), beliefs=()):
    log = []
    agent = bdi.Agent(
        program,
        beliefs=beliefs,
        act=lambda action: log.append({"t": agent.now, "action": str(action)}) or True,
        print=lambda line: log.append({"t": agent.now, "print": line}),
    )
    for entry in script:
        agent.add_percept(entry["add"])
        agent.advance(entry["t"])
    while agent.next_wakeup is not None:
        agent.advance(agent.next_wakeup)
    return log


def test_the_counter():
    program, *_ = blocks("agentspeak.md", "")
    console, *_ = blocks("agentspeak.md", "console")
    assert run(bdi.parse(program)) == entries(console)


def test_every_internal_action_is_named():
    page = (DOCS / "agentspeak.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(\.[a-z][\w.]*\w)", page))
    agent = bdi.Agent(bdi.parse("a."))
    missing = {name for name in agent.actions if name not in named}
    assert missing <= {"kqml.answer"}
    why_not = set(re.findall(r"^\| `(\.\w+)` \| no ", page, re.M))
    assert named - set(agent.actions) == why_not


def test_the_polite_person():
    plain, script, program, figures, *_ = blocks("write-a-personality.md", "")
    first, second, *_ = blocks("write-a-personality.md", "console")
    percepts = entries(script)
    stations = ["station(a, 0, 0)", "station(b, 8, 0)", "station(c, 8, 6)"]
    assert run(bdi.parse(plain), percepts, stations) == entries(first)
    expected = entries(second)
    watched = run(bdi.parse(program), percepts, stations)
    assert [entry for entry in watched if 12 <= entry["t"] < 25] == expected
    slower = run(
        bdi.parse(figures + '{ include("patrol.asl") }'), percepts, [*stations, "politeness(5000)"]
    )
    assert {"t": 20.0, "action": "move(8,0,0)"} in slower
