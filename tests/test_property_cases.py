"""Property tests try the same cases in every run."""

import sys

import pytest
from hypothesis import given, strategies as st


def cases():
    """Return the cases with which a property of any integers is tried."""
    tried = []

    @given(st.lists(st.integers(), min_size=10))
    def a_property(numbers):
        tried.append(numbers)

    a_property()
    return tried


def test_modules_that_are_loaded_make_no_difference(tmp_path, monkeypatch):
    before = cases()
    (tmp_path / "many_numbers.py").write_text(f"MANY = {list(range(90_000, 90_100))}\n")
    monkeypatch.syspath_prepend(tmp_path)
    pytest.importorskip("many_numbers")
    try:
        assert cases() == before
    finally:
        del sys.modules["many_numbers"]
