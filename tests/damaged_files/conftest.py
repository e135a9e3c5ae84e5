"""Fixtures of damaged files: the samples."""

import shutil

import pytest

from .readers import prepare


@pytest.fixture(scope="session")
def prepared(tmp_path_factory):
    """Return a folder of samples that no test changes."""
    folder = tmp_path_factory.mktemp("prepared")
    prepare(folder)
    return folder


@pytest.fixture(scope="module")
def folder(prepared, tmp_path_factory):
    """Return a copy of the samples for the tests of a module."""
    return shutil.copytree(prepared, tmp_path_factory.mktemp("samples"), dirs_exist_ok=True)
