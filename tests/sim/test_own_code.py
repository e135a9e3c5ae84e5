"""Python of the user's own: what stands beside the trial, whatever else has its name."""

import sys

import pytest

import sim
from sim.trials.own_code import OwnCodeError, find_own, source_of

CTL = "from .words import WORD\n\n\ndef go(gantry=None):\n    return WORD\n"


@pytest.fixture
def package(tmp_path):
    """Writes a package of two modules into a folder; gives the folder."""

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
    assert [find_own("pk.ctl:go", folder)() for folder in (ca, cb, ca, cb)] == [
        "ca",
        "cb",
        "ca",
        "cb",
    ]
    assert source_of("pk.ctl:go", cb) == str(cb / "pk" / "ctl.py")
    assert find_own("pk.ctl:go", ca) is find_own("pk.ctl:go", ca)


def test_a_package_itself_has_what_is_named(package):
    ca, cb = (package(name, regular=True) for name in ("ca", "cb"))
    assert [find_own("pk:WORD", folder) for folder in (ca, cb, ca)] == ["ca", "cb", "ca"]
    assert source_of("pk:WORD", cb) == str(cb / "pk" / "__init__.py")


def test_modules_beside_one_another_import_each_other(tmp_path):
    for name in ("ca", "cb"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "ctl.py").write_text(CTL.replace(".words", "words"))
        (tmp_path / name / "words.py").write_text(f"WORD = {name!r}\n")
    assert [find_own("ctl:go", tmp_path / name)() for name in ("ca", "cb", "ca")] == [
        "ca",
        "cb",
        "ca",
    ]


def test_what_others_imported_stays_theirs(package, monkeypatch):
    ca, cb = (package(name, regular=True) for name in ("ca", "cb"))
    monkeypatch.syspath_prepend(ca)
    import pk
    import pk.ctl

    theirs = {"pk": pk, "pk.ctl": pk.ctl}
    for _ in range(2):
        assert find_own("pk.ctl:go", cb)() == "cb"
        assert {name: sys.modules[name] for name in theirs} == theirs
    assert find_own("pk.ctl:go", ca) is pk.ctl.go


def test_a_package_that_is_not_beside_the_trial_is_imported_as_ever(package, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(package("ca", regular=True))
    assert find_own("pk.ctl:go", tmp_path)() == "ca"
    with pytest.raises(OwnCodeError, match=r"'pk.none:go' can't be imported: ModuleNotFound"):
        find_own("pk.none:go", tmp_path)


def test_what_fails_in_a_package_is_told_with_its_line(package):
    ca, cb = (package(name, regular=True) for name in ("ca", "cb"))
    (ca / "pk" / "ctl.py").write_text("\n1 / 0\n")
    for _ in range(2):
        with pytest.raises(OwnCodeError, match=r"'pk.ctl:go' can't be imported \(ctl.py, line 2\)"):
            find_own("pk.ctl:go", ca)
        assert find_own("pk.ctl:go", cb)() == "cb"


@pytest.mark.parametrize("name", ["..:go", ".:go", "a..b:go", "/:go", "a\0b:go", "\ud800:go"])
def test_odd_names_are_told(tmp_path, name):
    with pytest.raises(OwnCodeError, match="can't be imported"):
        find_own(name, tmp_path)


def test_trials_are_run_with_the_packages_of_their_own_folder(package):
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
