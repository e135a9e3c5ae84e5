"""Custom Python code beside the trial, also if other modules have the same name."""

import sys

import pytest

import sim
from sim.core.custom_code import CodeFolder
from sim.machines.controllers import loaded
from sim.machines.gantry.controllers import CONTROLLER, controller_source

CTL = "from .words import WORD\n\n\ndef go(gantry=None):\n    yield WORD\n"


def find_controller(name, folder):
    """Return a controller of gantries by its name, imported if it is custom."""
    return loaded(name, CONTROLLER, controller_source(name, folder))


def said(name, folder):
    """Return the first value that the controller yields."""
    return next(find_controller(name, CodeFolder(folder))(None))


@pytest.fixture
def package(tmp_path):
    """Return a function that writes a package of two modules into a folder."""

    def make(folder, *, regular, name="pk"):
        folder = tmp_path / folder
        (folder / name).mkdir(parents=True)
        if regular:
            (folder / name / "__init__.py").write_text(f"WORD = {folder.name!r}\n")
        (folder / name / "ctl.py").write_text(CTL)
        (folder / name / "words.py").write_text(f"WORD = {folder.name!r}\n")
        return folder

    return make


@pytest.fixture(autouse=True)
def _nothing_stays():
    before, path = {*sys.modules}, [*sys.path]
    yield
    assert sys.path == path
    for name in {*sys.modules} - before:
        if name.partition(".")[0] in ("pk", "ctl", "words"):
            del sys.modules[name]


@pytest.mark.parametrize("regular", [(True, True), (False, False), (True, False), (False, True)])
def test_packages_of_one_name_beside_two_trials(package, regular):
    ca, cb = (package(name, regular=one) for name, one in zip(("ca", "cb"), regular, strict=True))
    words = [said("pk.ctl:go", folder) for folder in (ca, cb, ca, cb)]
    assert words == ["ca", "cb", "ca", "cb"]
    assert controller_source("pk.ctl:go", CodeFolder(cb)).file == cb / "pk" / "ctl.py"


def test_a_package_provides_a_named_object(package):
    ca, cb = (package(name, regular=True) for name in ("ca", "cb"))
    for folder in (ca, cb):
        (folder / "pk" / "__init__.py").write_text(CTL)
    assert [said("pk:go", folder) for folder in (ca, cb, ca)] == ["ca", "cb", "ca"]
    assert controller_source("pk:go", CodeFolder(cb)).file == cb / "pk" / "__init__.py"


def test_modules_beside_one_another_import_each_other(tmp_path):
    for name in ("ca", "cb"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "ctl.py").write_text(CTL.replace(".words", "words"))
        (tmp_path / name / "words.py").write_text(f"WORD = {name!r}\n")
    folders = ("ca", "cb", "ca")
    assert [said("ctl:go", tmp_path / name) for name in folders] == [*folders]


def test_imports_of_others_are_not_replaced(package, monkeypatch):
    ca, cb = (package(name, regular=True) for name in ("ca", "cb"))
    monkeypatch.syspath_prepend(ca)
    import pk
    import pk.ctl

    theirs = {"pk": pk, "pk.ctl": pk.ctl}
    for _ in range(2):
        assert said("pk.ctl:go", cb) == "cb"
        assert {name: sys.modules[name] for name in theirs} == theirs
    assert find_controller("pk.ctl:go", CodeFolder(ca)) is not pk.ctl.go
    assert {name: sys.modules[name] for name in theirs} == theirs


def test_code_outside_the_folder_is_rejected(package, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(package("ca", regular=True))
    for name in ("pk.ctl:go", "subprocess:check_output", "os.path:join"):
        with pytest.raises(sim.ControllerError, match=r"there is no [\w/]+\.py in"):
            find_controller(name, CodeFolder(tmp_path))
    (tmp_path / "pk").mkdir()
    (tmp_path / "pk" / "ctl.py").write_text(CTL)  # packages precede namespaces
    with pytest.raises(sim.ControllerError, match=r"Python finds pk\.ctl in .*ca"):
        find_controller("pk.ctl:go", CodeFolder(tmp_path))


def test_a_failure_in_a_package_is_reported_with_its_line(package):
    ca, cb = (package(name, regular=True) for name in ("ca", "cb"))
    (ca / "pk" / "ctl.py").write_text(f"\n1 / 0\n{CTL}")
    for _ in range(2):
        message = r"'pk.ctl:go' can't be imported \(ctl.py, line 2\)"
        with pytest.raises(sim.ControllerError, match=message):
            find_controller("pk.ctl:go", CodeFolder(ca))
        assert said("pk.ctl:go", cb) == "cb"


@pytest.mark.parametrize(
    "name", ["..:go", ".:go", "a..b:go", "/:go", "a\0b:go", "a.if:go", "a:b.c"]
)
def test_odd_names_are_reported(tmp_path, name):
    with pytest.raises(sim.ControllerError, match="is not of the form package"):
        find_controller(name, CodeFolder(tmp_path))


NO_CONTROLLERS = """
from os import walk
from subprocess import check_output


def plain(gantry):
    def inner():
        yield 1
    return [inner]


async def later(gantry):
    yield 1


class Stands:
    pass


def swapped(gantry):
    yield 1


def given(gantry):
    yield 1


def wrap(function):
    return lambda gantry: function(gantry)


@wrap
def wrapped(gantry):
    yield 1


if True:
    from os import walk as given
    swapped = len
"""


@pytest.mark.parametrize(
    ("name", "message", "is_there"),
    [
        ("walk", r"m.py defines no class or function 'walk' at its top level", False),
        ("check_output", "no class or function 'check_output' at its top level", False),
        ("inner", "no class or function 'inner' at its top level", False),
        ("plain", r"'m:plain' \(m.py, line 6\) is no generator function, nor a class", True),
        ("later", r"'m:later' \(m.py, line 12\) is no generator function", True),
        ("Stands", "is no generator function, nor a class with a method __iter__", True),
        ("swapped", "<built-in function len> once m.py is imported, which is not defined", True),
        ("given", r"'m:given' is <function walk at", True),
        ("wrapped", "is no generator function, nor a class", True),
    ],
)
def test_only_a_controller_defined_in_the_module_is_accepted(tmp_path, name, message, is_there):
    (tmp_path / "m.py").write_text(NO_CONTROLLERS)
    with pytest.raises(sim.ControllerError, match=message):
        find_controller(f"m:{name}", CodeFolder(tmp_path))
    if is_there:
        assert controller_source(f"m:{name}", CodeFolder(tmp_path)).attribute == name
    else:
        with pytest.raises(sim.ControllerError, match=message):
            controller_source(f"m:{name}", CodeFolder(tmp_path))


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (b"def go(gantry:\n", r"can't be read \(m.py, line 1\): SyntaxError"),
        (b"# coding: nonsense\ndef go(gantry): yield\n", "can't be read.*unknown encoding"),
        (b"\0", "can't be read"),
        (b"x = " + b"-" * 100_000 + b"1\ndef go(gantry): yield\n", "can't be read"),
        (b"#" * 20_000_000, r"can't be read: .*m\.py: is larger than"),
        (b"x = '\\d'\ndef go(gantry): yield\n", ""),
    ],
)
def test_a_source_that_cannot_be_read_is_reported(tmp_path, source, message):
    (tmp_path / "m.py").write_bytes(source)
    if not message:  # Python warns of the escape at import
        assert controller_source("m:go", CodeFolder(tmp_path)).line == 2
        return
    with pytest.raises(sim.ControllerError, match=message) as caught:
        controller_source("m:go", CodeFolder(tmp_path))
    assert len(str(caught.value)) < 1000


@pytest.mark.parametrize("name", ["sys", "wave"])
def test_a_module_named_like_a_standard_module_is_rejected(tmp_path, name):
    (tmp_path / f"{name}.py").write_text("def go(gantry):\n    yield\n")
    with pytest.raises(sim.ControllerError, match=f"Python itself has a module '{name}'"):
        controller_source(f"{name}:go", CodeFolder(tmp_path))
    assert name != "wave" or name not in sys.modules


def test_trials_use_the_packages_of_their_folder(package):
    runs = []
    for name, x in (("ca", -3.0), ("cb", -5.0)):
        folder = package(name, regular=False)
        (folder / "pk" / "words.py").write_text(f"X = {x}\n")
        (folder / "pk" / "ctl.py").write_text(
            "from .words import X\n\n\ndef go(gantry):\n    yield gantry.move_to(X, 0.0)\n"
        )
        text = "floorplan: ariac2023\nduration: 20\ngantry: {controller: 'pk.ctl:go'}\n"
        (folder / f"{name}.trial.yaml").write_text(text)
        runs.append(sim.Trial.load(folder / f"{name}.trial.yaml"))
    ends = [sim.run(trial).motions["gantry"].position(20.0)[0] for trial in runs]
    assert ends == pytest.approx([-3.0, -5.0])


def test_the_folder_of_a_trial_gives_no_access_to_code_elsewhere(tmp_path):
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "ctl.py").write_text(CTL.replace(".words", "words"))
    text = "floorplan: ariac2023\nfolder: {}\ngantry: {{controller: 'ctl:go'}}\n".format
    for folder, up in (("code/rows", ".."), (".", "code"), ("code", ".")):
        trial = sim.Trial.parse(text(up), folder=tmp_path / folder)
        assert trial.folder.resolve() == tmp_path / "code"
        trial.to_yaml(tmp_path / "code" / "rows")
    with pytest.raises(sim.TrialError, match=r"2, folder: its code, ctl:go, stands in .*/code: so"):
        sim.Trial.parse(text("../code"), folder=tmp_path / "elsewhere")
    with pytest.raises(ValueError, match=r"written into .*elsewhere: its code, ctl:go, stands in"):
        trial.to_yaml(tmp_path / "elsewhere")


LOUD = """
from pathlib import Path

Path({touched!r}).touch()


class Law:
    def __init__(self, least=1.0):
        self.least = least

    def distance(self, human_speed, robot_speed):
        return self.least


def go(gantry):
    yield gantry.wait(1.0)
"""

OWN_LAW = """\
floorplan: ariac2023
duration: 2
people: [{name: ada}]
rules:
  gantry_law: {"loud:Law": {least: 2.0}}
"""
OWN_CONTROLLER = """\
floorplan: ariac2023
duration: 2
gantry: {controller: "loud:go"}
"""


@pytest.fixture
def loud(tmp_path):
    """A folder with code that writes a file when it is imported."""
    (tmp_path / "loud.py").write_text(LOUD.format(touched=str(tmp_path / "touched")))
    (tmp_path / "law.trial.yaml").write_text(OWN_LAW)
    (tmp_path / "controller.trial.yaml").write_text(OWN_CONTROLLER)
    (tmp_path / "rules.yaml").write_text("gantry_law: {'loud:Law': {}}\n")
    (tmp_path / "loud.study.yaml").write_text("trials: [controller.trial.yaml]\n")
    yield tmp_path
    sys.modules.pop("loud", None)


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize(
    ("named", "line"),
    [
        ("rules: {gantry_law: {'subprocess:check_output': {args: [touch, touched]}}}", 3),
        ("rules:\n  agv_law:\n    subprocess:Popen: {args: [touch, touched]}", 5),
        ("gantry: {controller: 'subprocess:check_output'}", 3),
    ],
)
def test_a_trial_cannot_run_code_outside_its_folder(tmp_path, floorwalker, command, named, line):
    (tmp_path / "t.yaml").write_text(f"floorplan: ariac2023\nduration: 2\n{named}\n")
    done = floorwalker(command, "t.yaml", cwd=tmp_path)
    assert done.returncode == 1
    assert f"t.yaml: line {line}, " in done.stderr
    assert "there is no subprocess.py in" in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"t.yaml"}


@pytest.mark.parametrize(
    "file", ["law.trial.yaml", "controller.trial.yaml", "rules.yaml", "loud.study.yaml"]
)
def test_check_imports_nothing(loud, floorwalker, file):
    assert floorwalker("check", file, cwd=loud).returncode == 0
    assert not (loud / "touched").exists()
    done = floorwalker("check", "--no-own-code", file, cwd=loud)
    assert done.returncode == 1
    assert "code of your own is refused here" in done.stderr
    assert "line " in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ["run", "law.trial.yaml", "--out", "out"],
        ["run", "ariac2023", "--controller", "loud:go", "--duration", "2", "--out", "out"],
        ["run", "ariac2023", "--rules", "rules.yaml", "--duration", "2", "--out", "out"],
        ["study", "loud.study.yaml", "--jobs", "1", "--out", "out"],
        ["metrics", "law.trial.yaml"],
        ["export", "controller.trial.yaml", "--out", "out.csv"],
        ["plot", "trails", "controller.trial.yaml", "--out", "out.svg"],
        ["plot", "heatmap", "law.trial.yaml", "--out", "out.svg"],
        ["render", "controller.trial.yaml", "--out", "out.gif", "--fps", "1"],
    ],
    ids=lambda words: " ".join(words[:2]),
)
def test_custom_code_runs_with_a_trial_unless_it_is_forbidden(loud, floorwalker, words):
    done = floorwalker(*words, "--no-own-code", cwd=loud)
    assert (done.returncode, "code of your own is refused here" in done.stderr) == (1, True)
    assert not [path for path in loud.iterdir() if path.name in ("touched", "out")]
    assert floorwalker(*words, cwd=loud).returncode == 0
    assert (loud / "touched").exists()


def test_a_study_may_forbid_custom_code(loud):
    (loud / "quiet.trial.yaml").write_text("floorplan: ariac2023\nduration: 2\n")
    study = "trials: [{trial}.trial.yaml]\nown_code: false\n"
    for text, place in (
        (study.format(trial="controller"), "line 1, trials[0]: "),
        (study.format(trial="quiet") + "grid: {controller: ['loud:go']}", "grid.controller[0]: "),
        (study.format(trial="quiet") + "grid: {rules: [paper, rules.yaml]}", "grid.rules[1]: "),
    ):
        with pytest.raises(sim.StudyError, match="code of your own is refused here") as caught:
            sim.Study.parse(text, folder=loud)
        assert place in str(caught.value)
    assert not (loud / "touched").exists()


def test_a_law_that_cannot_be_imported_leaves_no_recording(loud, floorwalker):
    (loud / "loud.py").write_text((loud / "loud.py").read_text() + "\n1 / 0\n")
    done = floorwalker("run", "law.trial.yaml", "--out", "out", cwd=loud)
    assert done.returncode == 1
    assert "law.trial.yaml: line 5, rules.gantry_law: the law 'loud:Law'" in done.stderr
    assert "(loud.py, line 18): ZeroDivisionError" in done.stderr
    assert not (loud / "out").exists()


def test_a_module_that_was_changed_immediately_is_read_again(tmp_path):
    for word in ("one", "two", "six"):
        (tmp_path / "ctl.py").write_text(f"def go(gantry=None):\n    yield '{word}'\n")
        assert said("ctl:go", tmp_path) == word


COUNTED = """
import words


class Law:
    def __init__(self):
        words.COUNT.append(1)

    def distance(self, human_speed, robot_speed):
        return float(len(words.COUNT))


def go(gantry):
    from words import COUNT
    yield gantry.move_to(-3.0 - len(COUNT), 0.0)
"""

COUNTING = """
floorplan: ariac2023
duration: 20
people: [{name: ada}]
gantry: {controller: "ctl:go"}
rules: {based_on: observe, gantry_law: {"ctl:Law": {}}}
"""


def test_state_in_a_module_beside_it_does_not_survive_a_run(tmp_path, monkeypatch):
    (tmp_path / "ctl.py").write_text(COUNTED)
    (tmp_path / "words.py").write_text("COUNT = []\n")
    trial = sim.Trial.parse(COUNTING, folder=tmp_path)
    runs = [sim.run(trial) for _ in range(2)]
    monkeypatch.syspath_prepend(tmp_path)
    del sys.modules["words"]
    import words

    words.COUNT.append(7)
    runs.append(sim.run(trial))
    assert words.COUNT == [7]
    assert sys.modules["words"] is words
    ends = [run.motions["gantry"].position(20.0)[0] for run in runs]
    assert ends == pytest.approx([-4.0] * 3)
    assert runs[0].events == runs[1].events == runs[2].events
