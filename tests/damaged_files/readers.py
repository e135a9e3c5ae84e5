"""Readers of files and foreign texts, by the sample that is damaged.

Accepted values are also used a little, because a file that is read and cannot be worked with
afterwards is as bad as one that breaks the reader.
"""

import asyncio
import json
import shutil
from pathlib import Path
from types import SimpleNamespace
from zlib import crc32

import h5py
import numpy as np

import bdi
import floorplan
import sim
from bdi.language.loading import parse_term
from navigation.benchmark import map_of, read_questions
from sim.bridge import Exchange, Workcell
from sim.bridge.client import Client
from sim.bridge.protocol import Account, Ledger
from sim.bridge.remote_agent import RemotePerson
from sim.bridge.uplink import ServerLink
from sim.commands.agent import read_percepts
from sim.core.clock import StandstillError
from sim.people.tracks.tables import read_hdf5_tracks, read_jupedsim_tracks, read_parquet_tracks
from sim.people.tracks.track_files import read_bag_tracks
from sim.studies.comparison import StudyResults
from sim.studies.folder import StudyFolder
from sim.studies.report import write_report
from sim.views.replay import recordings_in, render
from sim.views.replay_data import replay_data

SAMPLES = Path(__file__).parent / "samples"
RECORDED = """
floorplan: ariac2023
duration: 12.0
people: [{name: ada, personality: antagonistic, at: [-4.5, 2.0]}]
gantry: {controller: oblivious, at: [-2.5, 0.5, 0.0], jobs: [{move: [-3, 1, 0]}]}
agvs: {agv1: [{time: 0.5, to: as1}]}
"""
SERVED = """
floorplan: ariac2023
duration: 10000.0
people: [{name: operator, personality: external}]
gantry: {controller: external}
"""


def prepare(folder):
    """Write all samples, a recording (`run`), a study (`results`) and a page into `folder`."""
    shutil.copytree(SAMPLES, folder, dirs_exist_ok=True)
    recording = sim.Recording(folder / "run")
    recording.finish(sim.run(sim.Trial.parse(RECORDED), recording))
    page = render(replay_data(sim.load_run(folder / "run")))
    begin = page.index('<script type="application/json" id="recording">')
    (folder / "page.html").write_text(page[begin : page.index("</script>", begin) + 9])
    sim.run_study(sim.Study.load(folder / "one.study.yaml"), folder / "results", jobs=1)
    for name in ("bag", "track.mcap", "track.parquet", "track.sqlite"):
        sim.export(sim.load_run(folder / "run"), folder / name, rate=2.0)
    kinds = [("id", "i8"), ("frame", "i8"), ("x", "f8"), ("y", "f8")]
    with h5py.File(folder / "track.h5", "w") as file:
        rows = np.array([(1, k, 0.1 * k, 2.0) for k in range(9)], dtype=kinds)
        file.create_dataset("trajectory", data=rows).attrs["fps"] = 2.0


def trial(path):
    sim.Trial.load(path).to_yaml(path.parent)


def run(path):
    trial = sim.Trial.load(path)
    try:
        simulation = sim.Simulation(trial)
        simulation.advance(min(trial.duration, 3.0))
    except StandstillError:
        return  # only a run shows that time stands still
    except Exception as why:
        raise AssertionError(f"what was checked is refused as it begins: {why}") from why
    use(simulation.finish())


def bag(path):
    read_bag_tracks(path.parent)


def recording(path):
    use(sim.load_run(path.parent))


def use(run):
    """Use a run as the commands do: render its page, sample it, compute its metrics."""
    recordings_in(render(replay_data(run)))
    if run.duration <= 1000:
        run.sample(rate=2.0)
        sim.metrics(run)


def study(path):
    study = sim.Study.load(path)
    if len(study) <= 1000:
        study.row(len(study) - 1).trial.to_yaml(path.parent)


def results(path):
    """Add a row to the results of a study, and report on one table in ten."""
    study = sim.Study.load(path.parents[1] / "one.study.yaml")
    with StudyFolder(path.parent, study) as opened:
        if opened.table.rows < len(study):
            opened.table.add({"row": opened.table.rows, "error": None})
        rows = StudyResults(study, path.parent, opened.table.columns())
        if path.suffix == ".jsonl" and crc32(path.read_bytes()) % 10 == 0:
            write_report(rows, path.parent / "report.html")


def page(path):
    recordings_in(path.read_text(encoding="utf-8", errors="replace"))


def program(path):
    program = bdi.parse_file(path)
    bdi.parse(str(program), folder=path.parent)
    agent = bdi.Agent(
        program,
        act=lambda action: bool(str(action)),
        print=lambda line: None,
        society=bdi.Society(),
        settings=bdi.AgentSettings(on_event=lambda entry: None, max_cycles=2000, max_goals=3000),
    )
    agent.advance(0.0)
    agent.add_percept("human_start")
    agent.advance(5.0)
    for intention in agent.intentions:
        str(intention)


def literal(path):
    text = path.read_bytes().decode("utf-8", "replace")
    try:
        bdi.parse(f"{bdi.parse_literal(text)}.")
    finally:
        str(parse_term(text))


def to_server(path):
    """Take each line as a message of a client, while the simulation goes on."""

    async def take():
        exchange = Exchange()
        simulation = Workcell(sim.Trial.parse(SERVED), exchange).simulation

        async def send(text):
            json.loads(text)

        client = Client("somebody", send, Account(Ledger(), lambda why: None))
        sending = asyncio.ensure_future(client.send_forever())
        for line in path.read_bytes().split(b"\n"):
            exchange.take(client, line)
        simulation.advance(0.2)
        await client.idle(0.01)
        exchange.forget(client)
        sending.cancel()

    asyncio.run(take())


def to_agent(path):
    """Take each line as a message of the server that an agent is connected to."""

    async def take():
        trial = sim.Trial.parse(SERVED)
        exchange = Exchange()
        link = ServerLink(SimpleNamespace(send=None), exchange, lambda level, text, id: None)
        RemotePerson(
            trial,
            trial.people[0],
            bdi.Agent(bdi.parse("")),
            waypoints=False,
            notice=lambda text: None,
        ).connect(exchange, ())
        call = link._answers["call-1"] = asyncio.get_running_loop().create_future()
        for line in path.read_bytes().split(b"\n"):
            link.take(line)
        if call.done():
            call.exception()

    asyncio.run(take())


def questions(path):
    """Read a file of queries on the map that it names, or on the sample's floor."""
    floor = path.with_name("floor.yaml") if path.suffix == ".csv" else map_of(path)
    read_questions(path, floorplan.load(floor), radius=0.3)


READERS = {
    "work.trial.yaml": trial,
    "expectations.yaml": trial,
    "everything.ariac.yaml": trial,
    "short.trial.yaml": run,
    "laws.trial.yaml": run,
    "ours.rules.yaml": sim.load_rules,
    "many.study.yaml": study,
    "floor.yaml": floorplan.load,
    "holes.wkt": floorplan.load,
    "parts.wkt": floorplan.load,
    "floor.dxf": floorplan.load,
    "rooms.map": floorplan.load,
    "rooms.map.scen": questions,
    "questions.csv": questions,
    "map.yaml": floorplan.load,
    "map.pgm": lambda path: floorplan.load(path.with_name("map.yaml")),
    "map.png": lambda path: floorplan.load(path.with_name("picture.yaml")),
    "everything.asl": program,
    "running.asl": program,
    "other.asl": lambda path: bdi.parse_file(path.with_name("everything.asl")),
    "literals.txt": literal,
    "percepts.jsonl": read_percepts,
    "to_server.jsonl": to_server,
    "to_agent.jsonl": to_agent,
    "bag/bag.db3": bag,
    "bag/metadata.yaml": bag,
    "track.h5": read_hdf5_tracks,
    "track.mcap": read_bag_tracks,
    "track.parquet": read_parquet_tracks,
    "track.sqlite": read_jupedsim_tracks,
    "run/scene.json": recording,
    "run/summary.json": recording,
    "run/events.jsonl": recording,
    "run/motions.jsonl": recording,
    "run/thoughts.jsonl": recording,
    "run/violations.jsonl": recording,
    "page.html": page,
    "results/study.json": results,
    "results/results.jsonl": results,
}
"""By the name of the file in the folder that `prepare` fills."""
