"""Messages about what is wrong with the keys of a study, each with its remedy.

Kept apart from reading: the schema that they are made from takes longer than a small film.
"""

import difflib
import math
import reprlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from squeezefilm.config.film import key_paths_with_values
from squeezefilm.config.keys import (
    Schema,
    allowed_values_text,
    key_path_of_location,
    schema_of_key,
    unit_of_schema,
)
from squeezefilm.config.notes import unit_notes_of_value
from squeezefilm.sections import KeyPath, key_of_name
from squeezefilm.units import (
    NUMBER_PATTERN,
    corrected_quantity_text,
    number_in_unit,
    quantity_examples_text,
    quantity_of_unit,
)

KEY_ERROR_TYPES = ("missing", "extra_forbidden", "unexpected_keyword_argument")
SHAPE_OF_WORD = {"disc": "circle", "disk": "circle", "square": "rectangle", "oval": "ellipse"}
"""What people call the shapes of a pad."""
TEXT_ERROR_TYPES = ("string_pattern_mismatch", "string_too_short", "string_too_long")


def messages_of_errors(
    error: ValidationError, values: Mapping[str, Any], lines: Mapping[KeyPath, int]
) -> list[str]:
    """Return one message for each invalid key, in the order of the file."""
    messages: dict[KeyPath, tuple[int, str]] = {}
    for entry in error.errors(include_url=False):
        further = entry.get("ctx", {}).get("place", ())
        missing = entry["type"] == "missing" and not further
        key_path = key_path_of_location(entry["loc"], values, missing=missing) + further
        if key_path in messages:  # by another choice of a union
            continue
        if entry["type"] in KEY_ERROR_TYPES:
            text = _key_error_message(entry, key_path, schema_of_key(key_path[:-1], values))
        else:
            text = _value_error_message(entry, key_path, schema_of_key(key_path, values))
            if entry["type"] == "relation":
                text = "; ".join([text, *_unit_notes_of_section(key_path, values)])
        inner = next(
            (key_path[:end] for end in range(len(key_path), 0, -1) if key_path[:end] in lines), ()
        )
        messages[key_path] = lines[inner] if inner else 0, text
    in_order = sorted(
        messages, key=lambda key_path: (messages[key_path][0], list(map(str, key_path)))
    )
    reported = [messages[key_path] for key_path in in_order if messages[key_path][1]]
    return [f"line {line}: {text}" if line else text for line, text in reported]


def _unit_notes_of_section(section: KeyPath, values: Mapping[str, Any]) -> Iterator[str]:
    for key_path, value in key_paths_with_values(values):
        if key_path[: len(section)] == section:
            unit = unit_of_schema(schema_of_key(key_path, values))
            yield from unit_notes_of_value(key_path, value, unit)


def _key_error_message(error: Any, key_path: KeyPath, part: Schema) -> str:
    """Message about an unknown or missing key; empty where another error contains it."""
    *section, key = map(str, key_path)
    where, known = ".".join(section) or "top level", part.get("properties", {})
    if error["type"] != "missing":
        close = _close_match(key, known) or _close_match(key_of_name(key), known)
        hint = f"did you mean {close!r}?" if close else f"allowed are {', '.join(sorted(known))}"
        if key[:1].isdigit():
            hint = "write a decimal point: a comma begins another key"
        return f"{where}: unknown key {key!r}; {hint}"
    if key not in known:  # below a key that is not text
        return ""
    if any(_close_match(str(name), known) == key for name in error["input"] if name not in known):
        return ""
    wanted = known[key]
    inner = ", ".join(wanted.get("else", wanted).get("required", ()))
    words = allowed_values_text(wanted) or (f"a section with {inner}" if inner else "a section")
    unit = f" {wanted['unit']}" if "unit" in wanted else ""
    about = f": {wanted['description']}" if "description" in wanted else ""
    return f"{where}: missing {key!r} ({words}{unit}){about}"


def _value_error_message(error: Any, key_path: KeyPath, part: Schema) -> str:
    where, wrong, kind = ".".join(map(str, key_path)) or "top level", error["input"], error["type"]
    if kind == "relation":
        return f"{where}: {error['msg']}"
    if kind == "invalid_key" or (kind == "string_type" and error["loc"][-1] == "[key]"):
        return f"{where}: the key {reprlib.repr(wrong)} is not text"
    if kind.startswith("union_tag"):
        kinds = part["properties"]["kind"]
        if kind == "union_tag_not_found":
            return f"{where}: missing 'kind' ({allowed_values_text(kinds)})"
        wrong, where, part = error["ctx"]["tag"], f"{where}.kind", kinds
    if "enum" in part:
        close = SHAPE_OF_WORD.get(str(wrong), "")
        if close not in part["enum"]:
            close = _close_match(str(wrong), part["enum"], cutoff=0.7)  # "on" is not "none"
        hint = f"; did you mean {close!r}?" if close else ""
        return f"{where}: {wrong!r} is none of {allowed_values_text(part)}{hint}"
    value = reprlib.repr(wrong)
    if "const" in part and "description" in part:
        return f"{where}: {value} is not `{part['const']}`; {part['description']}"
    text = f"{where}: {value} {error['msg'].partition(' ')[2]}"
    if kind in TEXT_ERROR_TYPES and "description" in part:
        return f"{text}; it is the {part['description']}"
    if "properties" in part:
        return f"{where}: {value} is no section; its keys are {', '.join(part['properties'])}"
    unit = part.get("unit")
    if unit == "rad/m" and isinstance(wrong, str) and (number := number_in_unit(wrong, "1/m")):
        return (
            f"{where}: {value} is in radians or in waves per length; write '{number:.6g} rad/m', "
            f"or '{2 * math.pi * number:.6g} rad/m' for {number:.6g} waves per metre"
        )
    if unit and isinstance(wrong, str) and (corrected := corrected_quantity_text(wrong, unit)):
        return f"{where}: {value} should be a valid number; write {corrected!r}"
    written = NUMBER_PATTERN.match(wrong) if isinstance(wrong, str) else None
    own = quantity_of_unit(wrong[written.end() :]) if written else ""
    if unit and own and (wanted := quantity_of_unit(unit)):
        text = f"{where}: {value} is {own}; {wanted} is wanted"
    like = (
        f" {unit}, as a number or with its unit, like {quantity_examples_text(unit)}"
        if unit
        else ""
    )
    words = allowed_values_text(part)
    return f"{text}; allowed: {words}{like}" if words else text


def _close_match(key: str, known: Iterable[str], *, cutoff: float = 0.6) -> str:
    """The first of the keys that begin with this one, or the closest; "" if none is close."""
    begun = sorted(name for name in known if name.startswith(f"{key}_"))
    return next(iter(begun or difflib.get_close_matches(key, known, n=1, cutoff=cutoff)), "")
