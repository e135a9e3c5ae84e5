"""Dataclasses with methods that are compiled at their first use, compared with the standard's."""

import copy
import dataclasses
import inspect
import pickle
import threading

import pytest

from floorplan.files.dataclass import dataclass


@dataclass(frozen=True)
class Part:
    """Part with a default, a list of its own, and a field that is not compared."""

    name: str
    weight: float = 1.5
    tags: tuple[str, ...] = ()
    notes: list[str] = dataclasses.field(default_factory=list, compare=False, repr=False)

    def __post_init__(self):
        if self.weight < 0:
            raise ValueError("a weight is not negative")


@dataclasses.dataclass(frozen=True)
class StandardPart:
    name: str
    weight: float = 1.5
    tags: tuple[str, ...] = ()
    notes: list[str] = dataclasses.field(default_factory=list, compare=False, repr=False)


@dataclass(kw_only=True)
class Counter:
    """Mutable class with keywords only."""

    count: int = 0


@dataclass(frozen=True)
class Labelled:
    """Class with an explicit hash and representation."""

    label: str

    def __hash__(self):
        return 7

    def __repr__(self):
        return "labelled"


@dataclass(frozen=True, eq=False)
class Identity:
    """Class without comparison."""

    label: str


@dataclass(frozen=True)
class Bolt(Part):
    """Class with a base of the same kind."""

    thread: str = "M6"


@dataclasses.dataclass(frozen=True)
class Screw(Part):
    """Standard dataclass of a user with a base of this kind."""

    head: str = "hex"


class Nut(Part):
    """Class that is not a dataclass itself."""


def test_values_are_those_of_the_standard_dataclass():
    part, standard = Part("bolt", 2.0), StandardPart("bolt", 2.0)
    assert repr(part) == repr(standard).removeprefix("Standard")
    assert hash(part) == hash(standard)
    assert dataclasses.asdict(part) == dataclasses.asdict(standard)
    assert Part.__match_args__ == StandardPart.__match_args__
    assert str(inspect.signature(Part)) == str(inspect.signature(StandardPart))
    params = Part.__dataclass_params__, StandardPart.__dataclass_params__
    assert repr(params[0]) == repr(params[1])


def test_values_are_equal_if_their_compared_fields_are():
    assert Part("bolt", notes=["new"]) == Part("bolt")
    assert Part("bolt") != Part("nut")
    assert Part("bolt") != StandardPart("bolt")
    assert Identity("a") != Identity("a")
    assert len({Part("bolt"), Part("bolt"), Part("nut")}) == 2


def test_a_default_factory_is_called_for_each_value():
    assert Part("bolt").notes is not Part("nut").notes


def test_a_frozen_value_cannot_be_changed():
    part = Part("bolt")
    with pytest.raises(dataclasses.FrozenInstanceError, match="assign to field 'name'"):
        part.name = "nut"
    with pytest.raises(dataclasses.FrozenInstanceError, match="delete field 'name'"):
        del part.name
    with pytest.raises(dataclasses.FrozenInstanceError, match="other"):
        part.other = 1
    nut = Nut("nut")
    nut.other = 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        nut.weight = 1.0


def test_a_mutable_value_can_be_changed_and_has_no_hash():
    counter = Counter(count=1)
    counter.count += 1
    assert counter == Counter(count=2)
    with pytest.raises(TypeError, match="unhashable"):
        hash(counter)
    with pytest.raises(TypeError, match=r"Counter\.__init__"):
        Counter(1)


def test_explicit_methods_remain():
    assert hash(Labelled("a")) == 7
    assert repr(Labelled("a")) == "labelled"


@pytest.mark.parametrize("kind", [Part, Bolt, Screw, Nut])
def test_values_are_copied_and_pickled(kind):
    part = kind("bolt", 2.0, ("steel",))
    for other in (copy.copy(part), copy.deepcopy(part), pickle.loads(pickle.dumps(part))):
        assert other == part and type(other) is kind
    lighter = dataclasses.replace(part, weight=1.0)
    assert (lighter.name, lighter.weight) == ("bolt", 1.0)


def test_subclasses_inherit_fields_and_checks():
    assert [field.name for field in dataclasses.fields(Screw)][-1] == "head"
    for kind in (Part, Bolt, Screw, Nut):
        with pytest.raises(ValueError, match="negative"):
            kind("bolt", -1.0)


def test_missing_and_unknown_arguments_are_named():
    with pytest.raises(TypeError, match=r"Part\.__init__\(\) missing .*'name'"):
        Part()
    with pytest.raises(TypeError, match="'colour'"):
        Part("bolt", colour="red")


def test_a_value_matches_by_position():
    match Part("bolt", 2.0):
        case Part(name, weight):
            assert (name, weight) == ("bolt", 2.0)


def test_threads_may_use_a_class_for_the_first_time_together():
    kinds = [dataclass(frozen=True)(type(f"New{k}", (), {"__annotations__": {"x": int}}))
             for k in range(50)]  # fmt: skip
    barrier, made = threading.Barrier(4), []

    def make():
        barrier.wait()
        made.append([hash(kind(1)) for kind in kinds])

    threads = [threading.Thread(target=make) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert made == [[hash((1,))] * 50] * 4
