"""The configuration of a service: a dataclass whose fields are declared with `param`."""

import dataclasses
import difflib
import json
import math
import re
import tomllib
import typing

from .errors import UsageError

KINDS = {float: "number", int: "integer", bool: "boolean", str: "string"}


def param(default, doc, unit="", low=None, high=None):
    """A parameter: its default, one sentence, its unit, and the range of values accepted."""
    metadata = {"doc": doc, "unit": unit, "low": low, "high": high}
    return dataclasses.field(default=default, metadata=metadata)


def read(kind, path):
    """The configuration of a TOML file, or the defaults without one."""
    if path is None:
        return _make(kind, {}, "the defaults")
    try:
        with open(path, "rb") as file:
            text = file.read().decode()
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"configuration {path}: {error}") from None
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line = re.search(r"line (\d+)", str(error))
        place = line.group(1) if line else len(text.splitlines())
        raise UsageError(f"configuration {path}:{place}: {error}") from None
    fields, kinds = {field.name: field for field in dataclasses.fields(kind)}, kinds_of(kind)
    for name, value in values.items():
        problem = _problem(fields, kinds, name, value)
        if problem:
            place = _line_of(text, name)
            raise UsageError(f"configuration {path}:{place}: {name}: {problem}")
        if kinds[name] is float:
            values[name] = float(value)
    return _make(kind, values, path)


def kinds_of(kind):
    """Type of every field, also where annotations are text."""
    return typing.get_type_hints(kind)


def _make(kind, values, path):
    """The configuration itself; its `__post_init__` may reject values with a `ValueError`."""
    try:
        return kind(**values)
    except ValueError as error:
        raise UsageError(f"configuration {path}: {error}") from None


def _problem(fields, kinds, name, value):
    """What is wrong with a value; None when it is right."""
    if name not in fields:
        near = difflib.get_close_matches(name, fields, 1)
        hint = f", did you mean `{near[0]}`?" if near else ""
        return f"unknown field{hint}"
    field = fields[name]
    numeric = isinstance(value, (int, float)) and not isinstance(value, bool)
    right = numeric if kinds[name] is float else type(value) is kinds[name]
    if not right:
        return f"must be a {KINDS[kinds[name]]}, not {value!r}"
    low, high = field.metadata["low"], field.metadata["high"]
    try:
        finite = not numeric or math.isfinite(value)
    except OverflowError:
        finite = False
    if not finite:
        return "must be a finite number"
    if (low is not None and value < low) or (high is not None and value > high):
        return f"must be {low} to {high}, not {value}"
    return None


def _line_of(text, name):
    for place, line in enumerate(text.splitlines(), 1):
        if re.match(rf"\s*\[?\s*[\"']?{re.escape(name)}\b", line):
            return place
    return 1


def as_toml(config):
    """The configuration as TOML."""
    values = dataclasses.asdict(config)
    # JSON's numbers, strings and booleans are those of TOML.
    return "".join(f"{name} = {json.dumps(value)}\n" for name, value in values.items())


def as_json(kind):
    """The parameters as a JSON list."""
    kinds = kinds_of(kind)
    listed = [
        {
            "path": field.name,
            "type": KINDS[kinds[field.name]],
            "unit": field.metadata["unit"],
            "default": field.default,
            "min": field.metadata["low"],
            "max": field.metadata["high"],
            "description": field.metadata["doc"],
        }
        for field in dataclasses.fields(kind)
    ]
    return json.dumps(listed, indent=2)
