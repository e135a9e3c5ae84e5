"""A benchmark of planners as one page: tables, curves, boxes, and paths over each other."""

from .page import write_page

__all__ = ["write_page"]
