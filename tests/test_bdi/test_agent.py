"""The agent from outside: time, percepts, actions, and inspection."""

import gc
import math
import random

import pytest
from hypothesis import given, strategies as st

import bdi


def make(source, **options):
    """Return an agent that records its actions and lines with their times."""
    log = []
    agent = None

    def act(action):
        log.append((agent.now, str(action)))
        return True

    options.setdefault("act", act)
    options.setdefault("print", lambda line: log.append((agent.now, line)))
    agent = bdi.Agent(bdi.parse(source), **options)
    return agent, log


def test_an_agent_wakes_up_at_the_exact_times_in_order():
    agent, log = make(
        "!a. !b. +!a <- .wait(1000); at_1; .wait(100); at_1_1. +!b <- .wait(1100); also_at_1_1."
    )
    agent.advance(100.0)
    # Started first, the second wait of !a ends after the one of !b that began earlier.
    assert log == [(1.0, "at_1"), (1.1, "also_at_1_1"), (1.1, "at_1_1")]
    assert agent.now == 100.0


def test_repeated_waits_do_not_drift():
    source = "!a. +!a <- .wait(100); step; !a. +go <- .wait(200); other."
    agent, log = make(source)
    agent.advance(0.0)
    agent.add_percept("go")
    agent.advance(0.1)
    agent.advance(0.3)
    assert log == [(0.1, "step"), (0.2, "step"), (0.3, "other"), (0.3, "step")]


@given(st.lists(st.integers(0, 3000), min_size=1, max_size=12), st.integers(0, 2**32))
def test_waits_end_in_order_of_time_and_then_of_start(durations, seed):
    goals = " ".join(f"!w({i},{d})." for i, d in enumerate(durations))
    agent, log = make(goals + " +!w(I,D) <- .wait(D); done(I).")
    chance = random.Random(seed)
    time = 0.0
    while time < 4.0:
        agent.advance(time)
        time += chance.random()
    expected = sorted((duration, i) for i, duration in enumerate(durations))
    assert [(round(t * 1000), text) for t, text in log] == [(d, f"done({i})") for d, i in expected]


def test_next_wakeup_is_the_time_of_the_next_activity():
    agent, _ = make("!a. +!a <- .wait(250); .wait(500). +drop <- .drop_all_intentions.")
    assert agent.next_wakeup == 0.0
    agent.advance(0.0)
    assert agent.next_wakeup == 0.25
    agent.advance(0.25)
    assert agent.next_wakeup == 0.75
    agent.add_percept("drop")
    agent.advance(0.3)
    assert agent.next_wakeup is None


def test_an_agent_cannot_go_back_in_time():
    agent, _ = make("a.")
    agent.advance(2.0)
    with pytest.raises(ValueError, match="must not decrease"):
        agent.advance(1.0)


@pytest.mark.parametrize("time", [math.nan, math.inf, -math.inf])
def test_times_that_are_no_finite_numbers_are_rejected(time):
    program = bdi.parse("")
    with pytest.raises(ValueError, match=f"a finite number of seconds, not {time}"):
        bdi.Agent(program).advance(time)
    with pytest.raises(ValueError, match=f"a finite number of seconds, not {time}"):
        bdi.Agent(program, settings=bdi.AgentSettings(start=time))


def test_percepts_are_added_at_the_next_advance():
    agent, log = make("!a. +!a <- .wait(500); early. +p(X) <- saw(X). -p(X) <- lost(X).")
    agent.advance(0.0)
    agent.add_percept("p(1)")
    agent.advance(1.0)
    agent.remove_percept("p(1)")
    agent.add_percept("p(2)")
    agent.advance(2.0)
    agent.add_percept("p(2)")
    agent.remove_percept("p(3)")
    agent.advance(3.0)
    assert log == [(0.5, "early"), (1.0, "saw(1)"), (2.0, "lost(1)"), (2.0, "saw(2)")]
    assert [str(p) for p in agent.percepts] == ["p(2)"]


def test_percepts_from_an_action_are_added_immediately():
    def act(action):
        agent.add_percept(f"did({action.args[0]:g})")
        return True

    seen = []
    agent = bdi.Agent(
        bdi.parse("!go. +!go <- do(7). +did(X) <- .print(did, X)."), act=act, print=seen.append
    )
    agent.advance(0.0)
    assert seen == ["did7"]


def test_an_action_has_a_functor_and_arguments():
    taken = []
    source = '!go. +!go <- move(1.5, -2, "name", [1, b], f(x)).'
    agent = bdi.Agent(bdi.parse(source), act=lambda a: taken.append(a) or True)
    agent.advance(0.0)
    (action,) = taken
    assert action.functor == "move"
    number, integer, string, elements, structure = action.args
    assert (number, integer, string) == (1.5, -2.0, "name")
    assert list(elements) == [1.0, bdi.Literal("b")]
    assert (structure.functor, structure.args) == ("f", (bdi.Literal("x"),))
    assert str(action) == 'move(1.5,-2,"name",[1,b],f(x))'


def test_an_action_may_fail():
    agent, log = make("!go. +!go <- bad; never. -!go[error(E)] <- .print(E).", act=lambda a: False)
    agent.advance(0.0)
    assert log == [(0.0, "action_failed")]


def test_an_action_may_finish_later():
    requests = []

    def act(action):
        requests.append(str(action))
        return bdi.PENDING

    source = "!a. !b. +!a <- walk(1); .print(a,on). +!b <- walk(2). -!b <- .print(b,no)."
    agent, log = make(source, act=act)
    agent.advance(0.0)
    assert requests == ["walk(1)", "walk(2)"]
    assert sorted(map(str, agent.pending_actions.values())) == ["walk(1)", "walk(2)"]
    agent.finish("walk(2)", success=False)
    agent.advance(3.0)
    agent.finish(min(agent.pending_actions))
    agent.advance(4.0)
    assert log == [(3.0, "bno"), (4.0, "aon")]
    with pytest.raises(ValueError, match="walk"):
        agent.finish("walk(1)")


def test_other_intentions_wait_for_the_action_of_an_atomic_plan():
    agent, log = make("@x[atomic] +p(_) <- one; .wait(100); two. +q(_) <- other.")
    agent.advance(0.0)
    agent.add_percept("p(1)")
    agent.add_percept("q(1)")
    agent.advance(0.05)
    assert log == [(0.05, "one")]
    assert "q(1)" in {str(p) for p in agent.percepts}
    agent.advance(1.0)
    assert [text for _, text in log] == ["one", "two", "other"]


def test_intentions_can_be_inspected():
    agent, _ = make("b(1).\n!go.\n@walk\n+!go <- !sub(2).\n+!sub(X) <- .wait(1000);\n  done.")
    agent.advance(0.0)
    (intention,) = agent.intentions
    outer, inner = intention.stack
    assert (outer.plan.label.functor, str(outer.trigger)) == ("walk", "+!go[source(self)]")
    assert (str(inner.trigger), inner.place.line) == ("+!sub(2)[source(self)]", 5)
    assert [str(belief) for belief in agent.beliefs] == ["b(1)[source(self)]"]


def test_reprs_are_short():
    source = "p(1). q(X) :- p(X).\n!go.\n@l +!go : p(X) <- .wait(1000); walk(X)."
    program = bdi.parse(source, "x.asl")
    agent = bdi.Agent(program, society=bdi.Society(), act=lambda action: bdi.PENDING)
    agent.advance(0.5)
    assert repr(program) == "<Program x.asl: 2 beliefs, 1 goals, 1 plans>"
    assert repr(program.plans[0]) == "<Plan @l +!go : p(X) <- .wait(1000); walk(X)>"
    assert repr(agent) == "<Agent human at 0.5 s: 1 beliefs, 1 intentions>"
    assert repr(agent.intentions) == "[<Intention 1: +!go[source(self)]>]"
    assert repr(bdi.parse("x :- p(X) & not q(-X).").beliefs[0].body) == "<(p(X) & not (q((-X))))>"


def test_entries_report_internal_events():
    entries = []
    agent, _ = make(
        "!go(20). +!go(0) <- end. +!go(N) <- !go(N-1).",
        settings=bdi.AgentSettings(on_event=entries.append),
    )
    agent.advance(0.0)
    assert [e.kind for e in entries][-2:] == ["action", "ended"]
    assert entries[-2].line == 1


def test_beliefs_of_the_agent_precede_those_of_the_program():
    agent, log = make("speed(1). !go. +!go <- ?speed(X); .print(X).", beliefs=["speed(9)"])
    agent.advance(0.0)
    assert log == [(0.0, "9")]


def test_the_same_seed_draws_the_same_numbers():
    source = "!go. +!go <- .random(X); Y = math.random(10); .shuffle([1,2,3,4,5],L); .print(X,Y,L)."
    logs = []
    for seed in (1, 1, 2):
        agent, log = make(source, settings=bdi.AgentSettings(seed=seed))
        agent.advance(0.0)
        logs.append(log)
    assert logs[0] == logs[1] != logs[2]


def test_dates_count_simulated_time():
    agent, log = make(
        "!go. +!go <- .wait(3723004); .time(H,M,S,Ms); .date(Y,Mo,D); .print([H,M,S,Ms,Y,Mo,D])."
    )
    agent.advance(4000.0)
    assert log == [(3723.004, "[1,2,3,4,2023,1,1]")]


def test_custom_internal_actions_answer_queries_and_steps():
    actions = bdi.InternalActions()

    @actions.add("floor.distance", least=3, most=3)
    def distance(call, x, y, result):
        return call.unify(result, (x * x + y * y) ** 0.5)

    @actions.add("floor.corners", least=1, most=1)
    def corners(call, corner):
        return call.each(corner, [1, 2, 3])

    agent, log = make(
        "!go. +!go : floor.corners(C) & C > 1 <- floor.distance(3,4,D); .print(C,D).",
        actions=actions,
    )
    agent.advance(0.0)
    assert log == [(0.0, "25")]
    with pytest.raises(bdi.ProgramError, match=r"floor\.distance"):
        bdi.Agent(
            bdi.parse("!go. +!go <- floor.distanc(1,2,D)."),
            actions=actions,
            settings=bdi.AgentSettings(strict=True),
        )
    with pytest.raises(ValueError, match="dot"):
        actions.add("nodot")
    with pytest.raises(ValueError, match="already"):
        actions.add("floor.distance")


def test_unknown_internal_actions_are_rejected_by_strict_agents():
    source = "r :- .membr(1,[]). +!a : .atm(x) <- .drop_desir(x); if (.listt([])) { .prnt }."
    with pytest.raises(bdi.ProgramError) as wrong:
        bdi.Agent(bdi.parse(source, "x.asl"), settings=bdi.AgentSettings(strict=True))
    text = str(wrong.value)
    for hint in (".member?", ".atom?", ".drop_desire?", ".list?", ".print?"):
        assert hint in text
    assert len(wrong.value.problems) == 5


def test_unknown_internal_actions_are_warnings_unless_an_agent_is_strict():
    source = "!go. +!go <- .add_plan({ +!x <- .nosuch(1) }); !x. -!go[error(E)] <- .print(E)."
    warnings, lines = [], []
    program = bdi.parse("+!y <- .prnt.\n" + source, "x.asl")
    bdi.Agent(
        program,
        print=lines.append,
        settings=bdi.AgentSettings(on_event=warnings.append, kinds=["warning"]),
    ).advance(0.0)
    assert lines == ["action_failed"]
    # Unknown actions in the added plan are reported where it is written, and when it is added.
    assert [entry.text.partition(" (")[0] for entry in warnings] == [
        "x.asl:1:8: there is no internal action .prnt; did you mean .print?",
        "x.asl:2:14: there is no internal action .nosuch",
        "x.asl:2:33: there is no internal action .nosuch",
    ]
    with pytest.raises(bdi.ProgramError, match=r"x\.asl:1:8: there is no internal action \.prnt"):
        bdi.Agent(program, settings=bdi.AgentSettings(strict=True))


def test_wait_is_rejected_in_a_context():
    with pytest.raises(bdi.ProgramError, match=r"\.wait cannot be used in a context"):
        bdi.Agent(bdi.parse("+!a : .wait(1) <- b."))


def test_two_plans_with_the_same_label_are_rejected():
    with pytest.raises(bdi.ProgramError, match=r"x\.asl:2:.*@l"):
        bdi.Agent(bdi.parse("@l +!a <- b.\n@l +!c <- d.", "x.asl"))


@pytest.mark.parametrize(
    ("source", "place"),
    [
        ("!go.\n+!go <- while (true) { .length([],_) }.", "x.asl:2"),
        ("!go.\n+!go <- !go.", "x.asl:2"),
        ("!go.\n+!go <- !!go.", "x.asl:2"),
        ("!go.\n+!go <- !!other. +!other <- -+b(1).\n+b(_) <- !!go.", "x.asl"),
    ],
)
def test_endless_programs_are_stopped(source, place):
    agent = bdi.Agent(bdi.parse(source, "x.asl"), settings=bdi.AgentSettings(max_cycles=2000))
    with pytest.raises(bdi.EndlessProgramError, match="2000 cycles") as wrong:
        agent.advance(0.0)
    assert place in str(wrong.value)


@pytest.mark.parametrize(
    "source",
    [
        "!g.\n+!g <- !!g; !!g.",
        "!g.\n+!g <- .wait(1); !!g; !!g.",
        "!g.\n+!g <- !g |&| !g.",
        "!g.\n+!g <- !!g; .wait({+never}).",
    ],
)
def test_an_endless_number_of_intentions_is_stopped(source):
    agent = bdi.Agent(bdi.parse(source, "x.asl"), settings=bdi.AgentSettings(max_intentions=500))
    with pytest.raises(bdi.EndlessProgramError, match=r"x\.asl:2.*500 intentions"):
        agent.advance(60.0)
    assert len(agent.intentions) <= 501


def test_endless_waits_are_stopped():
    source = "!g.\n+!g <- !!g; .wait({+never})."
    agent = bdi.Agent(bdi.parse(source, "x.asl"), settings=bdi.AgentSettings(max_goals=1000))
    with pytest.raises(bdi.EndlessProgramError, match=r"x\.asl:2.*goals"):
        agent.advance(0.0)


def test_deep_recursion_of_goals_works_and_endless_recursion_is_stopped():
    source = "!go. +!go <- !sum(5000,S); .print(S). +!sum(0,0). +!sum(N,S) <- !sum(N-1,R); S = R+N."
    agent, log = make(source)
    agent.advance(0.0)
    assert log == [(0.0, "12502500")]
    agent, _ = make("!go. +!go <- !go; .print(x).", settings=bdi.AgentSettings(max_depth=1000))
    with pytest.raises(bdi.EndlessProgramError, match="too deeply"):
        agent.advance(0.0)


@pytest.mark.slow
def test_deep_recursion_of_rules_works_and_endless_recursion_is_stopped():
    source = "len([],0). len([_|T],N) :- len(T,M) & N = M+1."
    agent, log = make(
        source + "!go. +!go <- .findall(X,.range(X,1,10000),L); ?len(L,N); .print(N)."
    )
    agent.advance(0.0)
    assert log == [(0.0, "10000")]
    agent, _ = make("p(X) :- p(X). !go. +!go <- ?p(1).")
    with pytest.raises(bdi.EndlessProgramError, match="without end"):
        agent.advance(0.0)


def test_terms_nested_too_deeply_are_rejected():
    agent, _ = make("!go(x,0). +!go(T,N) : N < 5000 <- !go(f(T),N+1). +!go(T,N) <- .print(T).")
    with pytest.raises(bdi.EndlessProgramError, match="more than 150 deep"):
        agent.advance(0.0)


@pytest.mark.slow
def test_a_million_cycles_do_not_increase_memory():
    agent, _ = make("!go(100000). +!go(0). +!go(N) : N > 0 <- -+at(N); !!go(N-1).", print=None)
    agent.advance(0.0)
    gc.collect()
    before = len(gc.get_objects())
    agent.add_percept("again")
    agent.plans.add(bdi.parse("+again <- !!go(300000).").plans[0])
    agent.advance(1.0)
    gc.collect()
    assert len(gc.get_objects()) - before < 1000


def test_many_beliefs_are_found_by_their_first_argument():
    agent, log = make("+!ask(K) : b(K,V) <- .print(V). b(_,0) :- false.")
    for i in range(20_000):
        agent.believe(bdi.Literal("b", (float(i), float(i * i))))
    index = agent.beliefs.clauses["b", 2, False]
    query = bdi.parse_literal("b(777,X)")
    assert len(index.candidates(query, {})) == 2  # the belief and the rule
    agent.plans.add(bdi.parse("+p(K) <- !ask(K).").plans[0])
    agent.add_percept("p(777)")
    agent.advance(0.0)
    assert log == [(0.0, str(777 * 777))]


def test_stop_mas_ends_the_program():
    agent, log = make("!a. !b. +!a <- .wait(10); .stopMAS; never. +!b <- .wait(20); never.")
    agent.advance(1.0)
    assert agent.is_stopped
    assert log == []
    assert agent.next_wakeup is None
