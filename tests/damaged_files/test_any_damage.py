"""Any damage: the file is read, or one message names the damage."""

import pytest
from hypothesis import given, settings, strategies as st

from .damages import damaged
from .readers import READERS

OURS = ("floorplan", "navigation", "bdi", "sim")
VALUE_ERRORS = ("percepts.jsonl", "page.html")
"""Whose readers raise a plain `ValueError`."""


@pytest.mark.parametrize("name", READERS)
def test_the_sample_is_accepted(folder, name):
    READERS[name](folder / name)


@pytest.mark.parametrize("name", READERS)
@settings(max_examples=settings.default.max_examples // 6)
@given(data=st.data())
def test_a_damaged_file_is_read_or_rejected_with_a_message(folder, name, data):
    path = folder / name
    beside = {file: file.read_bytes() for file in path.parent.iterdir() if file.is_file()}
    path.write_bytes(data.draw(damaged(beside[path], path.suffix)))
    try:
        READERS[name](path)
    except Exception as why:
        ours = type(why).__module__.partition(".")[0] in OURS
        if not (ours or (name in VALUE_ERRORS and type(why) is ValueError)):
            raise
        assert 0 < len(str(why).strip()) < 20_000
    finally:
        for file, content in beside.items():
            if file.read_bytes() != content:
                file.write_bytes(content)
