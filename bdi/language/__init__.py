"""The language AgentSpeak: terms, programs, reading and writing.

`terms`, `operations` and `body` define the values. `substitution` and `unification` operate on
them. `parser`, `builder` and `loading` create a `program` from a text. Nothing here depends on
agents.
"""
