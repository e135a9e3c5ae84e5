"""Folders that are called after a trial or a study."""

from __future__ import annotations

import re
from pathlib import Path


def folder_for(name: str, parent: str) -> Path:
    """The folder right in `parent` for a trial or a study called `name`, whatever that is."""
    plain = re.sub(r"[/\\]", "-", name)
    return Path(parent) / (plain if plain.strip(".") else "unnamed")
