"""Keys of files that stand for values, and how they are read."""

from typing import Any, ClassVar

from floorplan import Number, Strictly

Pose = tuple[Number, Number, Number]


class Keys(Strictly):
    """Keys that stand for a value: a dataclass whose fields have the same names."""

    stands_for: ClassVar[type]

    def value(self) -> Any:
        """Return the value."""
        return self.stands_for(**self.fields())

    def fields(self) -> dict[str, Any]:
        """Return the fields of the value."""
        return {name: _value(getattr(self, name)) for name in type(self).model_fields}


def _value(key: Any) -> Any:
    """Return a key's value as a field has it."""
    if isinstance(key, list):
        return tuple(map(_value, key))
    return key.value() if isinstance(key, Keys) else key
