"""Damages of real files, and their places in the messages."""

import shutil

import pytest

import bdi
import floorplan
import sim

from .readers import SAMPLES, StudyFolder, read_percepts


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A folder with a short recording."""
    text = "floorplan: ariac2023\nduration: 3.0\npeople: [{name: ada}]\n"
    recording = sim.Recording(tmp_path_factory.mktemp("recording") / "run")
    recording.finish(sim.run(sim.Trial.parse(text), recording))
    return recording.folder


@pytest.mark.parametrize(
    ("name", "old", "new", "place"),
    [
        ("scene.json", "-22.0", "9" * 400, "scene.json: .* number"),
        ("scene.json", "-22.0", "-1e999", "scene.json: .* number"),
        ("scene.json", '"agv_law":{', '"agv_law":0,"x":{', "scene.json: rules: "),
        ("motions.jsonl", '"pieces": [[0.0', '"pieces": [[1e300', "line 1, pieces"),
        ("summary.json", '"penalties": 0', '"penalties": NaN', "summary.json: is not JSON"),
        ("summary.json", "{", "[" * 100_000, "summary.json: is not JSON"),
        ("events.jsonl", '"at": [', '"at": [1, ', "line 3: at of goal"),
        ("events.jsonl", '"at": [', '"at": [Infinity, ', "line 3: is not JSON"),
        ("events.jsonl", '"person": "ada"', '"person": ["ada"]', "person of human_started"),
        ("thoughts.jsonl", '"believes": [', '"believes": [7, ', "line 1, believes.0: "),
        ("thoughts.jsonl", '"t": 0.0', '"t": 0.0, "x": NaN', "line 1: is not JSON"),
    ],
)
def test_a_damaged_line_of_a_recording_is_named(recording, tmp_path, name, old, new, place):
    folder = shutil.copytree(recording, tmp_path / "run")
    text = (folder / name).read_text()
    assert old in text
    (folder / name).write_text(text.replace(old, new, 1))
    with pytest.raises(sim.RecordingError, match=place):
        sim.load_run(folder)


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('"row": 1', '"row": 7', 2),
        ('"penalties": 0', '"penalties": "many"', 1),
        ('"penalties": 0', '"penalties": Infinity', 1),
        ("max_speed", "speed", 1),
        ('{"digest"', '[{"digest"', 1),
        ("0.9", "\xe9", 1),
    ],
)
def test_damaged_results_of_a_study_are_named(tmp_path, old, new, line):
    (tmp_path / "t.yaml").write_text("floorplan: ariac2023\nduration: 1.0\npeople: [{name: a}]\n")
    text = "trials: [t.yaml]\ngrid: {max_speed: [0.9, 1.1]}\nrepeat: 1\n"
    study = sim.Study.parse(text, file=str(tmp_path / "s.yaml"), folder=tmp_path)
    with StudyFolder(tmp_path / "out", study) as folder:
        for row, speed in enumerate((0.9, 1.1)):
            folder.table.add({"row": row, "max_speed": speed, "error": None, "penalties": 2 * row})
    table = "row,max_speed,error,penalties\n0,0.9,,0\n1,1.1,,2\n"
    assert (tmp_path / "out" / "results.csv").read_text() == table
    rows = tmp_path / "out" / "results.jsonl"
    whole = rows.read_text()
    assert old in whole
    rows.write_text(whole.replace(old, new, 1), encoding="latin-1")
    with pytest.raises(ValueError, match=rf"results\.jsonl, line {line}: row {line - 1} "):
        sim.run_study(study, tmp_path / "out", jobs=1)


@pytest.mark.parametrize(
    "trial",
    [
        f"floorplan: {'x' * 300}.yaml",
        'floorplan: "a\\0.yaml"',
        f"floorplan: ariac2023\nrules: {'x' * 300}",
        f"floorplan: ariac2023\npeople: [{{name: ada, personality: {'x' * 300}}}]",
        'floorplan: ariac2023\npeople: [{name: ada, personality: "a\\0"}]',
        f"floorplan: ariac2023\nariac: {'x' * 300}",
    ],
)
def test_a_name_that_no_file_can_have_is_rejected(trial):
    with pytest.raises(sim.TrialError, match="<text>: line "):
        sim.Trial.parse(trial)


def test_a_distribution_of_nothing_is_rejected():
    text = "trials: [ariac2023]\nrandom: {max_speed: {normal: null}}"
    with pytest.raises(sim.StudyError, match=r"line 2, random\.max_speed: "):
        sim.Study.parse(text)


def test_a_law_with_a_number_too_large_for_a_float_is_rejected(tmp_path):
    (tmp_path / "r.yaml").write_text(f"agv_law: {{fixed: {'9' * 400}}}\n")
    with pytest.raises(floorplan.InputError, match=r"line 1, agv_law\.fixed\.metres: "):
        sim.load_rules(tmp_path / "r.yaml")


@pytest.mark.parametrize("t", ["9" * 400, "1e999", "true"])
def test_a_percept_without_a_time_is_rejected(tmp_path, t):
    (tmp_path / "p.jsonl").write_text(f'{{"t": {t}, "add": "a"}}\n')
    with pytest.raises(ValueError, match=r"p\.jsonl:1: .t. "):
        read_percepts(tmp_path / "p.jsonl")


def test_messages_stay_short_for_any_file(tmp_path):
    (tmp_path / "f.yaml").write_text("boundary: [[0,0],[1,0],[1,1]]\n" + "x" * 100_000 + ": 1\n")
    with pytest.raises(floorplan.FloorplanError) as floor:
        floorplan.load(tmp_path / "f.yaml")
    with pytest.raises(bdi.ProgramError) as program:
        bdi.parse("a b. " * 100 + "x " + "y" * 100_000 + ".", "p.asl")
    assert len(program.value.problems) == 101
    assert str(program.value).splitlines()[-1] == "and 81 more"
    with pytest.raises(bdi.ProgramError) as literal:
        bdi.parse_literal("a(" + "b" * 100_000)
    assert max(len(str(why.value)) for why in (floor, program, literal)) < 3000


def test_an_entity_unknown_to_ezdxf_has_no_layer(tmp_path):
    path = tmp_path / "floor.dxf"
    path.write_bytes((SAMPLES / "floor.dxf").read_bytes().replace(b"LWPOLYLINE", b"LWPOLY"))
    with pytest.raises(floorplan.FloorplanError, match="LWPOLY 2: can't be read as an outline"):
        floorplan.load(path)


def test_a_drawing_with_an_infinite_number_is_rejected(tmp_path):
    path = tmp_path / "floor.dxf"
    path.write_bytes((SAMPLES / "floor.dxf").read_bytes().replace(b"\n90\n4\n", b"\n90\n-inf\n"))
    with pytest.raises(floorplan.FloorplanError, match="is not a DXF drawing"):
        floorplan.load(path)


TOO_MUCH = {
    "nested lists": ("[" * 100_000, "nested too deeply"),
    "aliases of aliases": (
        "a: &a [x,x,x,x,x,x,x,x,x,x]\n"
        + "".join(
            f"{name}: &{name} [{','.join(['*' + before] * 10)}]\n"
            for before, name in zip("abcdefgh", "bcdefghi", strict=True)
        ),
        "more than 300,000 values",
    ),
    "an alias to itself": ("a: &a [*a]", "a[0]: an alias"),
    "10 MB": ("floorplan: ariac2023\n# " + "x" * 10_000_000, "longer than 4,000,000 characters"),
    "a list as a key": ("? [1, 2]\n: 1\n", "line 1: a key"),
    "a tag that promises too much": ("floorplan: !!bool maybe\n", "is not what its tag"),
    "an exponent without a sign": (
        "floorplan: ariac2023\nduration: 1e3\n",
        "line 2, duration: expected a number (to YAML 1e3 is text",
    ),
}


@pytest.mark.parametrize("case", TOO_MUCH)
def test_yaml_that_expands_too_far_is_rejected(case):
    text, message = TOO_MUCH[case]
    with pytest.raises(sim.TrialError) as refused:
        sim.Trial.parse(text)
    assert message in str(refused.value)


def test_only_the_first_of_many_problems_are_shown():
    text = "floorplan: ariac2023\nagvs:\n  agv1:\n" + "    - {time: x, to: warehouse}\n" * 500
    with pytest.raises(sim.TrialError) as refused:
        sim.Trial.parse(text)
    assert len(refused.value.problems) == 500
    lines = str(refused.value).splitlines()
    assert lines[0] == "<text>: 500 problems"
    assert lines[-1].strip() == "and 480 more"
    assert len(lines) == 22
