"""Plans that are added and removed while an agent runs."""

import pytest
from goals import said

import bdi

WORK = "@old +!work <- .print(old).\n@new +!work <- .print(new).\n"
ANY = "@own +!work <- .print(own).\n"
NO_PLAN = "no_relevant: Found a goal for which there is no relevant plan: +!work[source(self)]"


@pytest.mark.parametrize(
    ("removed", "lines"),
    [
        ("old", ["[new[source(self)]]", "new"]),
        ('["@old", new]', ["[]", NO_PLAN]),
        ("{+!work <- .print(old)}", ["[new[source(self)]]", "new"]),
        ("{@new +!work <- .print(whatever)}", ["[old[source(self)]]", "old"]),
        ("nobody", ["[old[source(self)],new[source(self)]]", "old"]),
        ("{+!rest <- true}", ["[old[source(self)],new[source(self)]]", "old"]),
        ("old, ann", ["[old[source(self)],new[source(self)]]", "old"]),
    ],
)
def test_a_plan_is_removed_by_its_label_or_by_its_text(removed, lines):
    body = f".remove_plan({removed}); .relevant_plans({{+!work}}, _, L); .print(L); !work"
    assert said(body, WORK) == lines


def test_a_plan_stays_until_its_last_source_is_gone():
    plan = "{+!work <- .print(work)}"
    body = (
        f".add_plan({plan}, ann); .add_plan({plan}, bob); .remove_plan({plan}); !work;"
        f" .remove_plan({plan}, ann); !work; .remove_plan({plan}, bob); !work"
    )
    assert said(body) == ["work", "work", NO_PLAN]


@pytest.mark.parametrize(
    ("body", "lines"),
    [
        ('.add_plan("@any +!G <- .print(any)"); !work; !rest', ["own", "any"]),
        ('.add_plan("@any +!G <- .print(any)", self, begin); !work; !rest', ["any", "any"]),
        (
            '.add_plan("@any +!G <- .print(any)", self, begin); !work; .remove_plan(any); !work',
            ["any", "own"],
        ),
        (
            '.add_plan("@any +!G <- .print(any)"); .remove_plan(own); !work; .remove_plan(any);'
            " !work",
            ["any", NO_PLAN],
        ),
        (
            '.add_plan(["+!G <- .print(any)", {+!rest <- .print(rest)}]); !rest; !work',
            ["any", "own"],
        ),
        (
            '.add_plan("@any +!G <- true"); .relevant_plans({+!rest}, _, L); .print(L);'
            " .relevant_plans({+!X}, _, M); .length(M, N); .print(N)",
            ["[any[source(self)]]", "3"],
        ),
    ],
)
def test_a_plan_for_all_goals_keeps_its_order_among_others(body, lines):
    assert said(body, ANY) == lines


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        ("@own +!rest <- true.", "there is already a plan with the label @own"),
        ("rest", "rest: a plan is expected"),
    ],
)
def test_a_plan_that_cannot_be_added_is_an_error(plan, message):
    (line,) = said(f'.add_plan("{plan}")', ANY)
    assert message in line


def test_a_file_with_errors_is_not_included(tmp_path):
    (tmp_path / "wrong.asl").write_text("+!work <- .\n")
    (tmp_path / "right.asl").write_text("+!work <- .print(included).\n")
    (tmp_path / "main.asl").write_text(
        '!go. +!go <- !try("wrong.asl"); !try("right.asl"); !work.'
        "+!try(F) <- .include(F). -!try(F)[error_msg(M)] <- .print(M)."
    )
    lines = []
    bdi.Agent(bdi.parse_file(tmp_path / "main.asl"), print=lines.append).advance(0.0)
    assert len(lines) == 2
    assert "wrong.asl:1:11: found" in lines[0]
    assert lines[1] == "included"
