"""Extension of griffe that reads Floorwalker's dataclasses as those of the standard library."""

from typing import Any

from griffe import Alias, Extension


class Dataclasses(Extension):
    """Point the decorator to the standard library, so that constructors have signatures."""

    def on_alias_instance(self, *, alias: Alias, **_: Any) -> None:
        """Replace the target of an imported decorator."""
        if alias.target_path.endswith("files.dataclass.dataclass"):
            alias.target_path = "dataclasses.dataclass"
