"""The keys of a study: what is allowed, in words; their table in the documentation.

All of it from the models' JSON schema, which ``squeezefilm config --schema`` prints for editors.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import yaml

from squeezefilm.config.study import Study
from squeezefilm.sections import KeyPath

Schema = Mapping[str, Any]
KeyNames = tuple[str, ...]
"""Of a JSON schema with references put in; ``kinds`` has that for each kind of a section."""

KEY_TABLE_HEADER = "| key | unit | allowed | default | meaning |\n| --- | --- | --- | --- | --- |\n"


@cache
def study_schema() -> Schema:
    """The JSON schema of a study, its parts in the places where it refers to them."""
    raw = Study.model_json_schema()

    def inline_references(part: Any) -> Any:
        if isinstance(part, list):
            return [inline_references(item) for item in part]
        if not isinstance(part, dict):
            return part
        if "$ref" in part:
            there = raw["$defs"][part["$ref"].rpartition("/")[2]]
            return inline_references(there) | {name: part[name] for name in part if name != "$ref"}
        if "prefixItems" in part:  # all of one kind
            return {**part, "items": inline_references(part["prefixItems"][0])}
        if "discriminator" in part:
            kinds = {
                choice["properties"]["kind"]["const"]: choice
                for choice in inline_references(part["oneOf"])
            }
            keys = {"kind": {"enum": list(kinds), "description": "it decides the other keys"}}
            return {**part, "properties": keys, "required": ["kind"], "kinds": kinds}
        return {name: inline_references(value) for name, value in part.items()}

    whole: Schema = inline_references({name: part for name, part in raw.items() if name != "$defs"})
    return whole


def key_path_of_location(location: KeyPath, values: Any, *, missing: bool = False) -> KeyPath:
    """Return the keys of a value that pydantic locates, without its steps to a union's choices.

    Args:
        location: of an error, as pydantic gives it.
        values: the sections that were validated.
        missing: the last step is a key that is not there.
    """
    key_path: KeyPath = ()
    part, kind = study_schema(), None
    for position, step in enumerate(location, start=1):
        written = step in values if isinstance(values, Mapping) else isinstance(step, int)
        if step == kind or not (written or (missing and position == len(location))):
            kind = None
            continue
        part, values = _child_schema(part, step, values), _child_value(values, step)
        kind = _child_value(values, "kind") if "kinds" in part else None
        key_path += (step,)
    return key_path


def schema_of_key(key_path: KeyPath, values: Any) -> Schema:
    """Return the part of the schema that describes a key's value, empty if none does."""
    part = study_schema()
    for step in key_path:
        part = _child_schema(part, step, values)
        values = _child_value(values, step)
    return _schema_of_kind(part, values)


def _child_value(values: Any, step: str | int) -> Any:
    """Return the value under a key or at a list's place, None where there is none."""
    try:
        return values[step]
    except (KeyError, IndexError, TypeError):
        return None


def _child_schema(part: Schema, step: str | int, values: Any) -> Schema:
    """Return the schema of what is under a key of these values, or in a list of them."""
    own = _schema_of_kind(part, values)
    key: Schema = own.get("properties", {}).get(step) or _pattern_properties_schema(own)
    return own.get("items", {}) if isinstance(step, int) else key


def _pattern_properties_schema(part: Schema) -> Schema:
    """Return the schema of the values in a section whose keys the user names."""
    named = part.get("additionalProperties") or {}
    return next(iter(part.get("patternProperties", {}).values()), named)


def _schema_of_kind(part: Schema, values: Any) -> Schema:
    kind = values.get("kind") if isinstance(values, Mapping) else None
    chosen: Schema = part.get("kinds", {}).get(str(kind), part)
    return chosen


def allowed_values_text(part: Schema) -> str:
    """Values that the schema allows, as a text; empty for a section."""
    if "enum" in part or "const" in part:
        values = part.get("enum", [part.get("const")])
        return ", ".join(f"`{value or repr(value)}`" for value in values)
    if "items" in part:
        return f"a list: {allowed_values_text(part['items'])}"
    if "anyOf" in part:
        return " or ".join(allowed_values_text(choice) or "a mapping" for choice in part["anyOf"])
    if "maximum" in part:
        low = f"{number_text(part['minimum'])} …" if "minimum" in part else "above 0, at most"
        return (
            f"{low} {number_text(part['maximum'])}{', whole' if part['type'] == 'integer' else ''}"
        )
    words = {"string": "text", "number": "a number", "boolean": "`true`, `false`"}
    return words.get(part.get("type", ""), "")


def number_text(value: float, *, digits: int = 5) -> str:
    """A limit or a default as it is written in texts."""
    text = f"{value:.{digits}g}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")
    return text.replace("-", "−") if text.startswith("-") else text


def key_table(whole: Schema) -> str:
    """Return a row of Markdown for each key: its unit, values, default and meaning."""
    rows = []
    for path, part, needed in _iter_key_schemas(whole):
        # A section in bold; of other keys the names below their section.
        name = f"`{'.'.join(path[1:])}`" if len(path) > 1 else f"**`{path[0]}`**"
        meaning = part["description"].replace("|", "\\|")
        cells = (
            name,
            unit_of_schema(part),
            allowed_values_text(part),
            _default_text(part, needed),
            meaning,
        )
        rows.append(f"| {' | '.join(cells)} |\n")
    return KEY_TABLE_HEADER + "".join(rows)


def _iter_key_schemas(part: Schema, path: KeyNames = ()) -> Iterator[tuple[KeyNames, Schema, bool]]:
    """Each key below a part of the schema: the names that lead to it, and whether it is needed."""
    for name, key in part.get("properties", {}).items():
        yield (*path, name), key, name in part.get("required", ())
        yield from _iter_key_schemas(key, (*path, name))
    if "patternProperties" in part:
        yield from _iter_key_schemas(_pattern_properties_schema(part), (*path, "NAME"))
    for kind, choice in part.get("kinds", {}).items():
        for key_path, key, needed in _iter_key_schemas(choice, path):
            if key_path[-1] != "kind":
                yield key_path, {**key, "description": f"of `{kind}`: {key['description']}"}, needed


def unit_of_schema(part: Schema) -> str:
    """The unit of a key's number, or of each in its list."""
    items = [part.get("items", {}), *part.get("prefixItems", ())]
    return str(next((each["unit"] for each in (part, *items) if "unit" in each), ""))


def _default_text(part: Schema, needed: bool) -> str:
    """Default of a key, or that it is required."""
    if "derived" in part or needed:
        return str(part.get("derived", "to be written"))
    value = part.get("default")
    if part.get("type") == "object":
        value = value or {}
    if "properties" in part or value is None:
        return ""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    text = (
        number_text(value, digits=12) if number else yaml.safe_dump(value, default_flow_style=True)
    )
    return f"`{text.removesuffix('...' + chr(10)).strip()}`"
