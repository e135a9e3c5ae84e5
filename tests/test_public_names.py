"""Every public name is explained where it is defined."""

import importlib
import inspect
import re
from typing import get_origin

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


def test_packages_say_what_they_are_for():
    assert [name for name in PACKAGES if not importlib.import_module(name).__doc__] == []


def test_classes_and_their_methods_have_docstrings():
    classes = [name for name in NAMES if is_class(value(name))]
    assert [name for name in classes if not own_docstring(value(name))] == []
    members = [member for name in classes for member in public_members(value(name))]
    assert [member for member, function in members if not own_docstring(function)] == []


def test_functions_say_what_each_parameter_is():
    functions = [name for name in NAMES if inspect.isfunction(value(name))]
    assert [name for name in functions if not own_docstring(value(name))] == []
    unnamed = [
        f"{parameter} of {name}"
        for name in functions
        for parameter in inspect.signature(value(name)).parameters
        if not re.search(rf"\b{parameter}\b", own_docstring(value(name)))
    ]
    assert unnamed == []
