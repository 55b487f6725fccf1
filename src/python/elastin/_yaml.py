"""Python values as the YAML that scenes are written in."""

import numbers
import os

import numpy


def text(value):
    """One line of YAML; numbers with all their digits."""
    if isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        return quoted(os.fspath(value))
    if value is None:
        return "null"
    if isinstance(value, (bool, numpy.bool_)):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {text(item)}" for key, item in value.items()) + "}"
    return "[" + ", ".join(map(text, value)) + "]"


def quoted(word):
    """A text that may hold what means something in YAML."""
    return "'" + word.replace("'", "''") + "'"


def overrides(changes):
    """{"key.path": value} as the command's --set takes it; a list of "key.path=value" stays as it is."""
    if changes is None:
        return []
    if isinstance(changes, dict):
        return [f"{key}={text(value)}" for key, value in changes.items()]
    return [changes] if isinstance(changes, str) else list(changes)
