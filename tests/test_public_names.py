"""Every public name is explained where it is defined."""

import importlib
import inspect
import re
from typing import get_origin

import pytest

PACKAGES = ("floorplan", "navigation", "bdi", "sim")
NAMES = [
    f"{package}.{name}" for package in PACKAGES for name in importlib.import_module(package).__all__
]


def value(name):
    package, _, attribute = name.partition(".")
    return getattr(importlib.import_module(package), attribute)


def is_class(of):
    """Return True for a class; on Python 3.10 `dict[str, Any]` says that it is one, too."""
    return inspect.isclass(of) and get_origin(of) is None


def own_docstring(of):
    """A docstring that somebody wrote: dataclasses make one of their signature."""
    text = of.__doc__ or ""
    made = inspect.isclass(of) and text.startswith(f"{of.__name__}(")
    return "" if made else text.strip()


def public_members(cls):
    for name, member in vars(cls).items():
        if name.startswith("_"):
            continue
        function = getattr(member, "__func__", getattr(member, "fget", member))
        if inspect.isfunction(function):
            yield f"{cls.__name__}.{name}", function


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_say_what_they_are_for(package):
    assert importlib.import_module(package).__doc__


@pytest.mark.parametrize("name", [name for name in NAMES if is_class(value(name))])
def test_classes_and_their_methods_have_docstrings(name):
    assert own_docstring(value(name))
    silent = [
        member for member, function in public_members(value(name)) if not own_docstring(function)
    ]
    assert silent == []


@pytest.mark.parametrize("name", [name for name in NAMES if inspect.isfunction(value(name))])
def test_functions_say_what_each_parameter_is(name):
    text = own_docstring(value(name))
    assert text
    parameters = inspect.signature(value(name)).parameters
    assert [one for one in parameters if not re.search(rf"\b{one}\b", text)] == []
