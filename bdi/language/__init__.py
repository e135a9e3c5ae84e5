"""AgentSpeak as a language: terms, programs, and how they are read and written.

From below: `terms` and `body` are the values, `substitution`, `unification` and `order` what can be
done with them; `tokens`, `parser`, `builder` and `loading` make a `program` of a text. Nothing here
knows of an agent.
"""
