"""Identity of results: it covers all files of the code that made them."""

import pytest

import sim
from sim.studies.identity import identity, parts

TRIAL = """
floorplan:
  name: hall
  boundary: [[0, 0], [20, 0], [20, 12], [0, 12]]
  safe_zone: {at: [2, 2]}
duration: 5
rules: {based_on: observe, agv_law: {"laws:Far": {}}}
steering: "manner:Plain"
people: [{name: ann, at: [2, 6], personality: calm, actions: acts}]
machines:
  m: {kind: amr, at: [10, 6, 0], controller: "pk.rev:go", rate: 10}
  t: {kind: "tug:Tug"}
"""

FILES = {
    "pk/__init__.py": "",
    "pk/rev.py": "from . import speeds\n\n\ndef go(v):\n    import late\n    return late.V, 0\n",
    "pk/speeds.py": "from shared import deep\n",
    "shared.py": "deep = 1\n",
    "late.py": "import importlib\nimportlib.import_module('plugin')\nV = 0.3\n",
    "plugin.py": "A = 1\n",
    "laws.py": "import lawhelp\n\n\nclass Far:\n    def distance(self, h, r):\n        return 1\n",
    "lawhelp.py": "A = 1\n",
    "manner.py": "import manners\n\n\nclass Plain:\n    def replan(self, b, n, o):\n        pass\n",
    "manners.py": "A = 1\n",
    "acts.py": "import bdi\nimport acthelp\nactions = bdi.InternalActions()\n\n\n"
    '@actions.add("my.act")\ndef act(call):\n    return True\n',
    "acthelp.py": "A = 1\n",
    "calm/calm.asl": '{ include("more.asl") }\n!live.\n+!live.\n',
    "calm/more.asl": "+!more.\n",
    "tug.py": "import tughelp\n\n\nclass Tug:\n    pass\n",
    "tughelp.py": "A = 1\n",
    "unused.py": "A = 1\n",
}


@pytest.fixture
def beside(tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("file", "part"),
    [
        ("pk/__init__.py", "the controller pk.rev:go"),
        ("pk/rev.py", "the controller pk.rev:go"),
        ("pk/speeds.py", "the controller pk.rev:go"),
        ("shared.py", "the controller pk.rev:go"),
        ("late.py", "the controller pk.rev:go"),
        ("plugin.py", "the controller pk.rev:go"),
        ("laws.py", "the law laws:Far"),
        ("lawhelp.py", "the law laws:Far"),
        ("manner.py", "the steering manner:Plain"),
        ("manners.py", "the steering manner:Plain"),
        ("acts.py", "the actions acts"),
        ("acthelp.py", "the actions acts"),
        ("calm/calm.asl", "the program calm"),
        ("calm/more.asl", "the program calm"),
        ("tug.py", "the machine t"),
        ("tughelp.py", "the machine t"),
        ("unused.py", None),
    ],
)
def test_each_file_that_is_imported_decides_the_results(beside, file, part):
    before = parts([sim.Trial.parse(TRIAL, folder=beside)])
    path = beside / file
    more = "+!also.\n" if path.suffix == ".asl" else "# changed\n"
    path.write_text(path.read_text() + more)
    after = parts([sim.Trial.parse(TRIAL, folder=beside)])
    assert before.keys() == after.keys()
    assert [what for what in before if before[what] != after[what]] == ([part] if part else [])


def test_code_that_imports_computed_names_depends_on_its_whole_folder(beside):
    (beside / "plugin.py").write_text("import importlib\nimportlib.import_module('un' + 'used')\n")
    before = parts([sim.Trial.parse(TRIAL, folder=beside)])
    (beside / "unused.py").write_text("A = 2\n")
    after = parts([sim.Trial.parse(TRIAL, folder=beside)])
    assert before != after


def test_controllers_of_one_name_in_two_folders_both_count(tmp_path):
    trials = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "go.py").write_text("def go(gantry):\n    yield gantry.wait(1.0)\n")
        text = f"floorplan: ariac2023\nname: {name}\ngantry: {{controller: 'go:go'}}\n"
        trials.append(sim.Trial.parse(text, folder=tmp_path / name))
    study = sim.Study("both", tuple(trials))
    before = identity(study)
    for name in ("a", "b"):
        (tmp_path / name / "go.py").write_text(
            f"def go(gantry):\n    yield gantry.wait({ord(name)})\n"
        )
        assert identity(study)["the controller go:go"] != before["the controller go:go"]
        before = identity(study)


def test_results_of_another_vehicle_controller_are_rejected(tmp_path):
    (tmp_path / "rev.py").write_text("def go(vehicle):\n    return (0.3, 0.0)\n")
    text = TRIAL.partition("rules")[0] + "machines:\n"
    text += '  m: {kind: amr, at: [10, 6, 0], controller: "rev:go", rate: 10}\n'
    study = sim.Study("s", (sim.Trial.parse(text, folder=tmp_path),), folder=tmp_path)
    sim.run_study(study, tmp_path / "out", jobs=1)
    (tmp_path / "rev.py").write_text("def go(vehicle):\n    return (1.2, 0.0)\n")
    with pytest.raises(sim.OutputError, match="the controller rev:go"):
        sim.run_study(study, tmp_path / "out", jobs=1)


def test_the_safety_report_names_controllers_of_trials_made_in_python(tmp_path):
    def slowly(vehicle):
        return 0.2, 0.0

    hall = sim.Trial.parse(TRIAL.partition("duration")[0]).floorplan
    keys = {"at": (10.0, 6.0, 0.0), "controller": slowly, "rate": 5.0}
    run = sim.run(sim.Trial(hall, duration=2.0, machines={"m": sim.MachineEntry("amr", keys)}))
    sim.safety_report(run, tmp_path / "r.html")
    assert "the controller test_the_safety_report" in (tmp_path / "r.html").read_text()
