"""YAML as people write it."""

from __future__ import annotations

from typing import Any

import yaml


def yaml_text(data: Any) -> str:
    """Return `data` as YAML: outermost keys on lines of their own, innermost values on one."""
    text: str = yaml.dump(
        data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, default_flow_style=None
    )
    return text


class _Dumper(yaml.SafeDumper):
    """Writes every value where it stands: files without anchors and aliases are easier to read."""

    def ignore_aliases(self, data: Any) -> bool:
        """Write `data` out even if it has been before."""
        return True

    def represent(self, data: Any) -> None:
        """Write `data`: the outermost keys on lines of their own, innermost values on one line."""
        node: Any = self.represent_data(data)
        node.flow_style = False
        self.serialize(node)
