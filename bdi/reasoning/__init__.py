"""The reasoning cycle of an agent: beliefs, plans, intentions, and what moves them on.

`cycle` takes a step: `deliberation` chooses a plan for an event, `execution` carries out a step of
an intention, `failure` and `achievement` end goals. `logic` answers formulas from the beliefs,
`circumstance` holds the events and intentions there are, and `state` is what all of them share.
"""
