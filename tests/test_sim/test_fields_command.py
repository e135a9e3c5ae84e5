"""The command `fields`: its output equals the values of the library."""

import math

import numpy as np
import pytest
import yaml

from navigation import FieldSet, ProtectiveFields, short_fields
from sim import Trial
from sim.machines.kinds import models_of

TRIAL = """\
floorplan: warehouse
duration: 30
machines:
  fork: {kind: amr, at: [10, 1.5, 0], size: [2.4, 0.8]}
  round_robot: {kind: amr, at: [14, 1.5, 0], drive: holonomic}
"""


@pytest.fixture
def trial(tmp_path):
    file = tmp_path / "t.yaml"
    file.write_text(TRIAL)
    return file


@pytest.mark.parametrize("source", ["the trial", "ariac2023"])
def test_fields_of_every_machine_are_long_enough(floorwalker, trial, source):
    source = trial if source == "the trial" else source
    done = floorwalker("fields", source, "--response-time", 0.3, "--wear", 0.2)
    assert done.returncode == 0
    assert max(map(len, done.stdout.splitlines())) <= 80
    read, written = Trial.load(source), yaml.safe_load(done.stdout)["fields"]
    models = models_of(read)
    assert written.keys() == models.keys()
    for name, section in written.items():
        sets = [FieldSet(**keys) for keys in section["sets"]]
        fields = ProtectiveFields(sets=sets, response_time=section["response_time"])
        footprint = models[name].shape(name, read.floorplan).footprint((0.0, 0.0), 0.0)
        limits = models[name].field_limits(read.floorplan)
        assert short_fields(fields, footprint, limits) == ()
        top = models[name].shape(name, read.floorplan).top_speed
        assert fields.gaps((0.0, top), (-1.0, 1.0)) == ()


def test_one_machine_with_its_speeds(floorwalker, trial):
    done = floorwalker("fields", trial, "--machine", "fork", "--speeds", "0.3,0.9")
    (section,) = yaml.safe_load(done.stdout)["fields"].values()
    assert [each["linear"] for each in section["sets"]][::2] == [
        [-0.3, 0.3],
        [0.3, 0.9],
        [-0.9, -0.3],
    ]
    assert "#  0.90" in done.stdout
    assert done.stderr == "fork: no set applies above 0.9 m/s\n"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--machine", "frk"), "no machine is called 'frk'; did you mean 'fork'?"),
        (("--machine", "fork", "--speeds", "9"), "fork: 9 m/s is above its top speed, 1.5 m/s"),
        (("--response-time", "nan"), "response_time must be 0 or more, not nan"),
        (("--side", "-1"), "side must be 0 or more, not -1.0"),
    ],
)
def test_wrong_arguments_are_rejected(floorwalker, trial, words, message):
    done = floorwalker("fields", trial, *words)
    assert done.returncode == 1
    assert done.stderr == f"floorwalker: {message}\n"
    assert done.stdout == ""


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("the trial", ()),
        ("the trial", ("--side", 0, "--wear", 0)),
        ("the trial", ("--approach-speed", 1.6)),
        ("ariac2023", ()),
    ],
)
def test_the_terms_of_the_table_add_up_to_the_length_of_the_polygon(
    floorwalker, trial, source, words
):
    source = trial if source == "the trial" else source
    done = floorwalker("fields", source, *words)
    read = Trial.load(source)
    models, rows = models_of(read), {}
    for line in done.stdout.splitlines():
        if line.startswith("  # ") and line.endswith(", m"):
            rows[line[4:].split(":")[0]] = table = []
        elif line.startswith("  # ") and "m/s" not in line:
            speed, _, *terms = line[4:].split()
            table.append((float(speed), [float(term) for term in terms]))
    for name, section in yaml.safe_load(done.stdout)["fields"].items():
        footprint = models[name].shape(name, read.floorplan).footprint((0.0, 0.0), 0.0)
        limits = models[name].field_limits(read.floorplan)
        for (speed, terms), each in zip(rows[name], section["sets"], strict=True):
            angle = 0.0 if speed > 0 else math.pi
            if "direction" in each and speed > limits.speed:
                angle = math.atan2(limits.side_speed, limits.speed)
            ahead = np.array([math.cos(angle), math.sin(angle)])
            edge = (np.array(footprint.exterior.coords) @ ahead).max()
            length = (np.array(each["protective"]) @ ahead).max() - edge
            assert terms[-1] == pytest.approx(length, abs=1e-3)
            assert sum(terms[:-1]) == pytest.approx(terms[-1], abs=1e-9)
            assert min(terms) >= 0


def test_a_trial_without_machines_has_no_fields(floorwalker):
    done = floorwalker("fields", "people_door")
    assert done.returncode == 1
    assert "people_door has no machine whose fields can be computed" in done.stderr


CUSTOM = """\
from dataclasses import dataclass

import navigation
import sim


@dataclass(frozen=True)
class Cart(sim.MachineModel):
    def shape(self, name, plan):
        size = {"length": 1.0, "width": 0.6, "top": 0.5, "top_speed": 1.0}
        return sim.MachineShape(name=name, kind="cart", category="vehicle", **size)

    def make(self, name, stage):
        raise NotImplementedError
"""

LIMITS = """
    def field_limits(self, plan):
        return navigation.VehicleLimits(speed=1.0)
"""


def test_a_custom_kind_has_fields_if_its_model_has_limits(floorwalker, tmp_path):
    (tmp_path / "t.yaml").write_text(
        "floorplan: warehouse\nduration: 9\nmachines: {cart: {kind: 'carts:Cart'}}\n"
    )
    for code, has_fields in ((CUSTOM, False), (CUSTOM + LIMITS, True)):
        (tmp_path / "carts.py").write_text(code)
        done = floorwalker("fields", tmp_path / "t.yaml", "--machine", "cart")
        assert (done.returncode == 0) == has_fields
        assert ("cart" in done.stdout) == has_fields
