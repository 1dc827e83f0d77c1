"""The keys of a study: what is allowed, in words; their table in the documentation.

All of it from the models' JSON schema, which ``squeezefilm config --schema`` prints for editors.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import yaml

from squeezefilm.config.study import Study
from squeezefilm.sections import KeyPath

Part = Mapping[str, Any]
"""Of a JSON schema with references put in; ``kinds`` has that for each kind of a section."""

TABLE_HEAD = "| key | unit | allowed | default | meaning |\n| --- | --- | --- | --- | --- |\n"


@cache
def schema() -> Part:
    """The JSON schema of a study, its parts in the places where it refers to them."""
    raw = Study.model_json_schema()

    def inlined(part: Any) -> Any:
        if isinstance(part, list):
            return [inlined(item) for item in part]
        if not isinstance(part, dict):
            return part
        if "$ref" in part:
            there = raw["$defs"][part["$ref"].rpartition("/")[2]]
            return inlined(there) | {name: part[name] for name in part if name != "$ref"}
        if "discriminator" in part:
            kinds = {
                choice["properties"]["kind"]["const"]: choice for choice in inlined(part["oneOf"])
            }
            keys = {"kind": {"enum": list(kinds), "description": "it decides the other keys"}}
            return {**part, "properties": keys, "required": ["kind"], "kinds": kinds}
        return {name: inlined(value) for name, value in part.items()}

    whole: Part = inlined({name: part for name, part in raw.items() if name != "$defs"})
    return whole


def part_at(steps: KeyPath, values: Any) -> tuple[KeyPath, Part]:
    """Return the key path that steps lead to, and its part of the schema, empty if none.

    What an error of pydantic says among its steps of the choices of a union is dropped.
    """
    key_path: KeyPath = ()
    part = schema()
    for step in steps:
        if isinstance(step, str) and values is not None:
            written = isinstance(values, Mapping)
            if not written or (step not in values and step in ("[key]", values.get("kind"))):
                continue
        own = _of_kind(part, values)
        key = own.get("properties", {}).get(step) or _pattern_schema(own)
        part = own.get("items", {}) if isinstance(step, int) else key
        key_path += (step,)
        try:
            values = values[step]
        except (KeyError, IndexError, TypeError):
            values = None
    return key_path, _of_kind(part, values)


def _pattern_schema(part: Part) -> Part:
    """Return the schema of the values in a section whose keys the user names."""
    return next(iter(part.get("patternProperties", {}).values()), {})


def _of_kind(part: Part, values: Any) -> Part:
    kind = values.get("kind") if isinstance(values, Mapping) else None
    chosen: Part = part.get("kinds", {}).get(str(kind), part)
    return chosen


def allowed(part: Part) -> str:
    """Values that the schema allows, as a text; empty for a section."""
    if "enum" in part or "const" in part:
        return ", ".join(f"`{value}`" for value in part.get("enum", [part.get("const")]))
    if "items" in part:
        return f"a list: {allowed(part['items'])}"
    if "anyOf" in part:
        return " or ".join(allowed(choice) or "a mapping" for choice in part["anyOf"])
    if "maximum" in part:
        low = f"{shown(part['minimum'])} …" if "minimum" in part else "above 0, at most"
        return f"{low} {shown(part['maximum'])}{', whole' if part['type'] == 'integer' else ''}"
    return {"string": "text", "boolean": "`true`, `false`"}.get(part.get("type", ""), "")


def shown(value: float, *, digits: int = 5) -> str:
    """A limit or a default as it is written in texts."""
    text = f"{value:.{digits}g}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")
    return text.replace("-", "−") if text.startswith("-") else text


def key_table(whole: Part) -> str:
    """Return a row of Markdown for each key: its unit, values, default and meaning."""
    rows = []
    for path, part, needed in _keys(whole):
        # A section in bold; of other keys the names below their section.
        name = f"`{'.'.join(path[1:])}`" if len(path) > 1 else f"**`{path[0]}`**"
        meaning = part["description"].replace("|", "\\|")
        cells = (name, unit_of(part), allowed(part), _default(part, needed), meaning)
        rows.append(f"| {' | '.join(cells)} |\n")
    return TABLE_HEAD + "".join(rows)


def _keys(part: Part, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Part, bool]]:
    """Each key below a part of the schema: the names that lead to it, and whether it is needed."""
    for name, key in part.get("properties", {}).items():
        yield (*path, name), key, name in part.get("required", ())
        yield from _keys(key, (*path, name))
    if "patternProperties" in part:
        yield from _keys(_pattern_schema(part), (*path, "NAME"))
    for kind, choice in part.get("kinds", {}).items():
        for key_path, key, needed in _keys(choice, path):
            if key_path[-1] != "kind":
                yield key_path, {**key, "description": f"of `{kind}`: {key['description']}"}, needed


def unit_of(part: Part) -> str:
    """The unit of a key's number, or of each in its list."""
    return str(part.get("unit", part.get("items", {}).get("unit", "")))


def _default(part: Part, needed: bool) -> str:
    """Default of a key, or that it is required."""
    if "derived" in part or needed:
        return str(part.get("derived", "to be written"))
    value = part.get("default")
    if "properties" in part or value is None:
        return ""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    text = shown(value, digits=12) if number else yaml.safe_dump(value, default_flow_style=True)
    return f"`{text.removesuffix('...' + chr(10)).strip()}`"
