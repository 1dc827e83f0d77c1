"""What is wrong with a study's values, each mistake once: key, unit, range and remedy."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from typing import Any

from squeezefilm.studies.schema import Part, allowed, part_at, short

HAVE_TEXT = ("pattern", "minLength", "maxLength")


def mistakes(values: Mapping[str, Any], whole: Part) -> Iterator[str]:
    """A line for each mistake, which begins with its key; numbers with units are in SI already.

    ``whole`` is the schema, or what of it the values are of.
    """
    from jsonschema import Draft202012Validator  # slow to import, and only needed here

    # A value that has no kind has no other keys to be judged by.
    found = sorted(
        Draft202012Validator(whole).iter_errors(values),
        key=lambda error: [str(each) for each in error.absolute_path],
    )
    told: set[Any] = set()
    for error in found:
        place = tuple(error.absolute_path)
        where = ".".join(map(str, place)) or "top level"
        part = part_at(place, values)
        if error.validator == "additionalProperties":
            known = list(part.get("properties", {}))
            lines = [
                _of_short_key(where, key, error.instance, part)
                or f"{where}: unknown key {key!r}{_hint(key, known)}"
                for key in error.instance
                if key not in known
            ]
        elif error.validator == "required":
            lines = [
                f"{where}: missing {key!r}{_wanted(part['properties'][key])}"
                for key in error.validator_value
                if key not in error.instance and not _misspelled(key, error.instance, part)
            ]
        elif place in told:
            continue
        else:
            told.add(place)
            lines = [f"{where}: {error.message}{_remedy(part, error)}"]
        for line in lines:
            if line not in told:
                told.add(line)
                yield line


def _of_short_key(where: str, key: Any, values: Mapping[str, Any], part: Part) -> str:
    """What is wrong with a key without its unit, whose value then has to have it; else empty."""
    whole = next((name for name, its in part["properties"].items() if short(name, its) == key), "")
    if not whole:
        return ""
    if whole in values:
        return f"{where}: {key!r} and {whole!r} are one key; write one of them"
    unit = part["properties"][whole]["unit"]
    value = values[key]
    told = f"{value!r} is no number with a unit of {unit}"
    if isinstance(value, Mapping | list):
        told = "each number there needs a unit that fits"
    return f"{where}.{key}: {told}; or write {whole!r}, a number in {unit}"


def _hint(key: Any, known: list[str]) -> str:
    close = difflib.get_close_matches(str(key), known, n=1)
    return f"; did you mean {close[0]!r}?" if close else f"; allowed are {', '.join(sorted(known))}"


def _misspelled(key: str, values: Mapping[str, Any], part: Part) -> bool:
    """Whether a key that is missing is there under a name that is told to be it."""
    known = list(part["properties"])
    unknown = [name for name in values if name not in known]
    return any(difflib.get_close_matches(name, known, n=1) == [key] for name in unknown)


def _wanted(part: Part) -> str:
    """A key that is missing: what it may be, and what it is."""
    unit = f" {part['unit']}" if "unit" in part else ""
    inner = part.get("required", ())
    words = allowed(part) or (f"a section with {', '.join(inner)}" if inner else "a section")
    about = f": {' '.join(part['description'].split())}" if "description" in part else ""
    return f" ({words}{unit}){about}"


def _remedy(part: Part, error: Any) -> str:
    if error.validator in HAVE_TEXT and "description" in part:
        return f"; it is the {' '.join(part['description'].split())}"
    if error.validator == "enum":
        close = difflib.get_close_matches(str(error.instance), part.get("enum", ()), n=1)
        return f"; did you mean {close[0]!r}?" if close else ""
    words = allowed(part)
    if not words:
        return f"; a section has keys: {', '.join(part['properties'])}" * ("properties" in part)
    unit = part.get("unit")
    if not unit or part.get("type") != "number":
        return f"; allowed: {words}"
    from squeezefilm.io.typed_units import examples

    return f"; allowed: {words} {unit}, as a number or with its unit, like {examples(unit)}"
