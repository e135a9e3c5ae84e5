"""People believe bodies to be where they are, whenever they ask."""

import pytest
from hypothesis import given, settings, strategies as st
from run_events import events

import sim
import sim.simulation
from sim.people import population as company

LOOKS = """
+human_start <- !look; move(5, -10, 0).
+!look
  <- ?me(X, Y, V); .print("operator ", X, " ", Y, " ", V);
     ?gantry(GX, GY, GV); .print("gantry ", GX, " ", GY, " ", GV);
     for (agv(N, AX, AY, AV)) {{ .print(N, " ", AX, " ", AY, " ", AV) }};
     .wait({every}); !look.
+me(_, _, _) <- event.
+gantry(_, _, _) <- event.
+agv(_, _, _, _) <- event.
"""

TRIAL = """
floorplan: ariac2023
duration: 20.0
people: [{name: operator, personality: looks.asl, at: [-15, -10]}]
gantry:
  controller: oblivious
  jobs: [{move: [-7.0, 2.0, 0.0]}, {move: [-2.5, 0.5, 1.0]}]
agvs:
  agv1: [{time: 1.0, to: assembly_front}]
  agv4: [{time: 2.0, to: warehouse}]
"""


@given(st.integers(150, 2000))
@settings(max_examples=10)
def test_what_is_believed_is_how_it_is_then(tmp_path_factory, every):
    folder = tmp_path_factory.mktemp("looks")
    (folder / "looks.asl").write_text(LOOKS.format(every=every))
    run = sim.run(sim.Trial.parse(TRIAL, folder=folder))
    said = events(run, "said")
    assert len(said) == 6 * (20_000 // every + (20_000 % every > 0))
    moving = 0
    for event in said:
        name, *figures = event["text"].split()
        state = run.motions[name].state(event["t"])
        assert tuple(map(float, figures)) == pytest.approx((*state.at, state.speed), abs=1e-6)
        moving += state.speed > 0.1
    assert moving > 5


def test_a_mind_that_does_not_look_asks_nothing(monkeypatch):
    asked = []
    live_beliefs = company.live_beliefs

    def counted(*bodies):
        return {
            key: lambda key=key, source=source: asked.append(key) or source()
            for key, source in live_beliefs(*bodies).items()
        }

    monkeypatch.setattr(company, "live_beliefs", counted)
    run = sim.run(sim.Trial.load("ariac2023"))
    assert run.summary["people"]["operator"]["visits"]
    assert run.thoughts == () and not asked
