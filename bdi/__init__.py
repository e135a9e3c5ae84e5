"""Interpreter of AgentSpeak in the dialect of Jason: the minds of people.

```python
program = bdi.parse_file("human.asl")
agent = bdi.Agent(program, beliefs=["helpful"], act=my_action)
agent.add_percept("human_start")
agent.advance(12.5)
```

Names are imported when they are first used, from the modules in `__init__.pyi`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
