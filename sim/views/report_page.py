"""Reports: HTML pages of one look that need nothing else."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..core.output import write_whole


def write_report_page(
    path: Path, template: str, filters: Mapping[str, Callable[..., str]], **values: Any
) -> None:
    """Write the page that a template of `data/report` makes of `values` to `path`.

    `filters` are functions that the template names.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("sim", "data/report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= filters
    write_whole(path, environment.get_template(template).render(**values))
