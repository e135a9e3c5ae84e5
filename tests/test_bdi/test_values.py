"""Public values of the package: copies, pickles, annotations and keyword arguments."""

import copy
import inspect
import pickle
import typing

import pytest

import bdi

PROGRAM = bdi.parse("at(dock, X) :- berth(X). b(1). !go. @l +!go : at(dock, _) <- walk.")
PROBLEM = bdi.ProgramProblem(file="a.asl", line=1, column=2, message="wrong")
VALUES = [
    PROGRAM,
    *PROGRAM.beliefs,
    *PROGRAM.goals,
    *PROGRAM.plans,
    bdi.parse_literal('~at([a, "s"|T], f(X))[source(S)]'),
    bdi.Var("X"),
    PROBLEM,
    bdi.Message(sender="a", force="tell", content=bdi.parse_literal("b(1)")),
    bdi.Entry(time=1.5, kind="print", text="hello", intention=2, file="a.asl", line=3),
    bdi.Refused("too far"),
]
COPIES = [copy.deepcopy, copy.copy, lambda value: pickle.loads(pickle.dumps(value))]


@pytest.mark.parametrize("copied", COPIES)
@pytest.mark.parametrize("value", VALUES, ids=lambda value: type(value).__name__)
def test_copies_of_values_are_equal(value, copied):
    assert copied(value) == value
    assert str(copied(value)) == str(value)


@pytest.mark.parametrize("copied", COPIES)
@pytest.mark.parametrize("kind", [bdi.ProgramError, bdi.EndlessProgramError])
def test_copies_of_errors_have_the_same_problems(kind, copied):
    error = kind([PROBLEM, PROBLEM])
    assert type(copied(error)) is kind
    assert copied(error).problems == error.problems
    assert str(copied(error)) == str(error)


@pytest.mark.parametrize("copied", COPIES)
def test_pending_has_one_instance(copied):
    assert copied(bdi.PENDING) is bdi.PENDING


@pytest.mark.parametrize("copied", COPIES)
def test_copying_an_agent_raises_an_error_with_the_reason(copied):
    agent = bdi.Agent(PROGRAM)
    with pytest.raises(TypeError, match=r"bdi\.Agent\(agent\.program, …\)"):
        copied(agent)


def public_callables():
    for name in bdi.__all__:
        value = getattr(bdi, name)
        if inspect.isfunction(value):
            yield name, value
        if not inspect.isclass(value):
            continue
        yield name, value
        for attribute, member in inspect.getmembers(value):
            function = getattr(member, "fget", member)
            if inspect.isfunction(function) and function.__module__.startswith("bdi"):
                yield f"{name}.{attribute}", function


def test_annotations_can_be_read():
    wrong = []
    for name, function in public_callables():
        try:
            typing.get_type_hints(function)
        except NameError as error:
            wrong.append(f"{name}: {error}")
    assert wrong == []
