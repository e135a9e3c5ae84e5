"""Folders named after a trial or a study."""

from __future__ import annotations

import re
from pathlib import Path


def folder_for(name: str, parent: str) -> Path:
    """Return the folder right in `parent` for a trial or a study named `name`, whatever it is."""
    plain = re.sub(r"[/\\]", "-", name)
    return Path(parent) / (plain if plain.strip(".") else "unnamed")
