"""The fastest safe loader of YAML that is installed."""

from __future__ import annotations

from typing import Any

import yaml
from yaml.composer import Composer
from yaml.constructor import SafeConstructor
from yaml.resolver import Resolver


def safe_loader(text: str) -> Any:
    """A safe loader of `text`: PyYAML's, with LibYAML's parser where PyYAML has it.

    That is five times as fast. Nodes are composed in Python in any case, where nesting too deep
    is an error and not the end of the process.
    """
    return _WithLibYaml(text) if yaml.__with_libyaml__ else yaml.SafeLoader(text)


if yaml.__with_libyaml__:
    from yaml._yaml import CParser

    class _WithLibYaml(Composer, CParser, SafeConstructor, Resolver):
        def __init__(self, text: str) -> None:
            CParser.__init__(self, text)
            Composer.__init__(self)
            SafeConstructor.__init__(self)
            Resolver.__init__(self)
