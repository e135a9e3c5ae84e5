"""Parts of the reasoning cycle: beliefs, plans and intentions.

`deliberation` chooses a plan for an event. `execution` carries out a step of an intention, and
`failure` ends goals. `contexts` and `logic` evaluate formulas over the beliefs. `circumstance`
contains the events and intentions, and `state` all shared values.
"""
