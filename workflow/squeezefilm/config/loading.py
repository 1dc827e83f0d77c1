"""Reading a study from YAML: all that is wrong with it at once, each with its line and remedy.

And writing it down as it is computed.
"""

import difflib
import json
import math
import os
import re
import reprlib
from collections.abc import Iterable, Iterator, Mapping
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import ValidationError

from squeezefilm.config.film import FilmSections, key_paths_with_values
from squeezefilm.config.keys import (
    Schema,
    allowed_values_text,
    key_path_of_location,
    schema_of_key,
    unit_of_schema,
)
from squeezefilm.config.study import Study
from squeezefilm.errors import InputError
from squeezefilm.files import read_text, write_text
from squeezefilm.film.pad import Pad
from squeezefilm.film.profiles import Sinc, StandingWave
from squeezefilm.film.scene import Actuator
from squeezefilm.sections import KeyPath, key_of_name
from squeezefilm.units import (
    DECIMAL_REGEX,
    NUMBER_PATTERN,
    corrected_quantity_text,
    number_in_unit,
    quantity_examples_text,
    quantity_of_unit,
)

FilmSectionsT = TypeVar("FilmSectionsT", bound=FilmSections)

CONFIGURATION_FILE_LABEL = "configuration file"
YAML_LITERALS = {"true": True, "false": False, "null": None, "~": None, "": None}
INTEGER_PATTERN = re.compile(r"[-+]?(?:0|[1-9]\d*)", re.ASCII)
FLOAT_PATTERN = re.compile(
    rf"(?!{INTEGER_PATTERN.pattern}$)(?!0\d){DECIMAL_REGEX}|[-+]?\.(?:inf|nan)", re.I | re.ASCII
)
MAX_INTEGER_DIGITS = 18
STUDY_FILE_NAME = "study.yaml"
"""The name of the file beside a study's results."""
PLAN_SECTION_NAMES = ("screen", "extrapolation")
"""Sections that a study needs beside its film."""
KEY_ERROR_TYPES = ("missing", "extra_forbidden", "unexpected_keyword_argument")
TEXT_ERROR_TYPES = ("string_pattern_mismatch", "string_too_short", "string_too_long")


class FilmWithoutStudyError(InputError):
    """A file has a film and no plan, so that it is no study."""


def load_config(path: Path | str) -> Study:
    """Read and validate the file of a study; what it lacks has its default.

    Raises InputError naming the file, line and key, what is wrong with it and what is allowed;
    FilmAloneError for a film without a study.
    """
    return _parse_sections(
        read_text(path, what=CONFIGURATION_FILE_LABEL), path=Path(path), model=Study
    )


def load_film(path: Path | str) -> FilmSections:
    """Read the film of a study; sections that only a study has are not checked and may be missing.

    Raises InputError as ``load_config`` does.
    """
    return _parse_sections(
        read_text(path, what=CONFIGURATION_FILE_LABEL), path=Path(path), model=FilmSections
    )


def parse_config(text: str, *, path: Path) -> Study:
    """Validate the text of a study, which is or will be at ``path``.

    Raises InputError as ``load_config`` does.
    """
    return _parse_sections(text, path=path, model=Study)


def _parse_sections(text: str, *, path: Path, model: type[FilmSectionsT]) -> FilmSectionsT:
    values, lines = _read_yaml(text, path=path)
    if (
        model is Study
        and {"actuator", "pad"} <= {*values}
        and not {*PLAN_SECTION_NAMES} & {*values}
    ):
        raise FilmWithoutStudyError(
            f"{path}: a film without a study: `squeezefilm simulate`, `levitate` and, in Python, "
            f"`sf.Film.read` take it; a study also has a name, study, and the sections "
            f"{' and '.join(PLAN_SECTION_NAMES)}"
        )
    for name in Study.model_fields.keys() - model.model_fields.keys():
        values.pop(name, None)
    return validated_sections(values, path=path, lines=lines, model=model)


def validated_sections(
    values: Mapping[str, Any],
    *,
    path: Path,
    model: type[FilmSectionsT],
    lines: Mapping[KeyPath, int] | None = None,
) -> FilmSectionsT:
    """Validate sections by the keys of a file.

    Args:
        path: the file that they are of, or a name for where they are from.
        model: what they are to be, a study or its film.
        lines: of the file, at which keys and items stand.

    Raises InputError as ``load_config`` does.
    """
    try:
        return model.model_validate(values).with_source(path, values)
    except ValidationError as error:
        messages = _messages_of_errors(error, values, lines or {})
        raise InputError("\n".join(f"{path}: {message}" for message in messages)) from None


def with_changed_keys(config: FilmSectionsT, changes: Mapping[str, Any]) -> FilmSectionsT:
    """The study with other values of some keys, which stand in a file as ``gas.viscosity`` does.

    Raises InputError as ``load_config`` does.
    """
    values = config.model_dump(exclude_none=True, by_alias=True)
    for key_path, value in changes.items():
        *sections, key = key_path.split(".")
        reduce(getitem, sections, values)[key] = value
    return validated_sections(values, path=config.path, model=type(config))


def _read_yaml(text: str, *, path: Path) -> tuple[dict[str, Any], dict[KeyPath, int]]:
    """The values of a YAML text, and the line of each.

    Of YAML its plain part: true, false, null, decimal numbers, text, lists and mappings, for YAML's
    own rules read 12:30 as 750 and 010 as 8. A key may stand only once, and no alias: a file is
    no larger than it looks.
    """
    lines: dict[KeyPath, int] = {}
    seen: set[yaml.Node] = set()

    def value_of_node(node: yaml.Node, key_path: KeyPath) -> Any:
        if node in seen:
            line = node.start_mark.line + 1
            raise InputError(f"{path}: line {line}: an alias of this value is not allowed")
        seen.add(node)
        lines.setdefault(key_path, node.start_mark.line + 1)
        if isinstance(node, yaml.SequenceNode):
            return [value_of_node(item, (*key_path, i)) for i, item in enumerate(node.value)]
        if isinstance(node, yaml.ScalarNode):
            return node.value if node.style else _parse_yaml_scalar(node.value)
        values: dict[str, Any] = {}
        for key, value in node.value:
            name, line = key.value, key.start_mark.line + 1
            if not isinstance(name, str) or name in values:
                what = "stands twice" if isinstance(name, str) else "is not text"
                raise InputError(f"{path}: line {line}: the key {reprlib.repr(name)} {what}")
            lines[*key_path, name] = line
            values[name] = value_of_node(value, (*key_path, name))
        return values

    try:
        # A base loader takes every scalar as text; that in C is ten times faster.
        node = yaml.compose(text, Loader=getattr(yaml, "CBaseLoader", yaml.BaseLoader))
        values = value_of_node(node, ()) if node else None
    except yaml.YAMLError as error:
        reason = " ".join(str(error).split()).replace('"<unicode string>", ', "")
        mark = getattr(error, "problem_mark", None)
        line = text.splitlines()[mark.line : mark.line + 1] if mark else []
        hint = "; indent by spaces: YAML allows no tab there" if "\t" in "".join(line) else ""
        raise InputError(f"{path}: not valid YAML: {reason}{hint}") from None
    except RecursionError:
        raise InputError(f"{path}: nested too deeply") from None
    if not isinstance(values, dict):
        raise InputError(f"{path}: a configuration is a mapping of keys to values")
    return values, lines


def _parse_yaml_scalar(text: str) -> Any:
    if text in YAML_LITERALS:
        return YAML_LITERALS[text]
    if INTEGER_PATTERN.fullmatch(text):
        return int(text) if len(text) <= MAX_INTEGER_DIGITS else float(text)
    return (
        float(text.replace(".i", "i").replace(".n", "n")) if FLOAT_PATTERN.fullmatch(text) else text
    )


def _messages_of_errors(
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
            written = key_paths_with_values(values) if entry["type"] == "relation" else ()
            inside = {
                place: value for place, value in written if place[: len(key_path)] == key_path
            }
            text = "; ".join([text, *_unit_notes_of_values(inside, values)])
        inner = next(
            (key_path[:end] for end in range(len(key_path), 0, -1) if key_path[:end] in lines), ()
        )
        messages[key_path] = lines[inner] if inner else 0, text
    in_order = sorted(
        messages, key=lambda key_path: (messages[key_path][0], list(map(str, key_path)))
    )
    reported = [messages[key_path] for key_path in in_order if messages[key_path][1]]
    return [f"line {line}: {text}" if line else text for line, text in reported]


def _key_error_message(error: Any, key_path: KeyPath, part: Schema) -> str:
    """Message about an unknown or missing key; empty where another error contains it."""
    *section, key = map(str, key_path)
    where, known = ".".join(section) or "top level", part.get("properties", {})
    if error["type"] != "missing":
        close = _close_match(key, known) or _close_match(key_of_name(key), known)
        hint = f"did you mean {close!r}?" if close else f"allowed are {', '.join(sorted(known))}"
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
        close = _close_match(str(wrong), part["enum"])
        hint = f"; did you mean {close!r}?" if close else ""
        return f"{where}: {wrong!r} is none of {allowed_values_text(part)}{hint}"
    value = reprlib.repr(wrong)
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


def _close_match(key: str, known: Iterable[str]) -> str:
    return next(iter(difflib.get_close_matches(key, known, n=1)), "")


def effective_yaml(config: FilmSections, *, folder: Path | None = None) -> str:
    """The whole study or film as YAML that reads as the same; what was not written says so.

    Args:
        folder: where the text will lie, for the paths of the files that the study names; by
            default beside the study.
    """
    sections = config.model_dump(exclude_none=True, by_alias=True)
    outline, measured = sections["pad"].get("outline", {}), sections.get("measurements", {})
    named = sections["actuator"]["profile"], outline, measured
    figures = sections.get("figures", {})
    for section, key in (*((model, "file") for model in named), (figures, "style")):
        if folder is not None and key in section:
            # ".." leads elsewhere from a folder that is a link.
            file = config.path.parent.resolve() / section[key]
            section[key] = os.path.relpath(file, start=folder.resolve())
    head = f"# {config.path}, all keys: values without a mark are written in that file.\n"
    return head + "".join(f"{line}\n" for line in _config_as_yaml_lines(sections, (), config))


USUAL_RANGE_AND_INPUT_UNIT = {"Hz": (1e3, math.inf, "kHz"), "m": (0.0, 1.0, "mm")}
"""Range of a study's frequencies and lengths, and the unit that people give them in."""
PAPERS_ACTUATOR = Actuator(43.27e3, 10e-3, profile=Sinc(wave_number_per_m=109.8))
PAPERS_PAD = Pad(10e-3, 10e-3)
"""The film whose claims, tables and figures a study with ``paper: true`` makes."""
PAPERS_GAS_SETTINGS = {"rarefaction": "none", "polytropic_exponent": 1, "inertia": "none"}
PAPERS_GAS_SETTINGS |= {"thermal": "none"}


def differences_from_paper(config: Study) -> Iterator[str]:
    """Yield what makes the film of a study another than the paper's, by its keys."""
    for name, papers in (("actuator", PAPERS_ACTUATOR), ("pad", PAPERS_PAD)):
        if getattr(config, name) != papers:
            yield f"another {name}"
    for key, value in PAPERS_GAS_SETTINGS.items():
        if (own := getattr(config.gas, key)) != value:
            yield f"gas.{key} {own}"


def study_notes(config: Study) -> Iterator[str]:
    """Yield notes on what is valid and probably not meant.

    ``unit_notes``, ``target_force_notes``, a study with the name of another file's, of the paper
    with another film, a standing wave without a model that repeats along it.
    """
    namesake = config.path.with_name(f"{config.study}.yaml")
    if namesake.name != config.path.name and namesake.exists():
        yield (
            f"study: {config.study} is the study of {namesake}: results/{config.study} would hold "
            f"the results of both; write another name, such as {config.path.stem}"
        )
    if config.paper and (changes := list(differences_from_paper(config))):
        yield (
            f"paper: true, but {', '.join(changes)}: its pages name a variant of the paper; leave "
            "paper out where the paper's claims are not to be compared"
        )
    yield from target_force_notes(config)
    if isinstance(config.actuator.profile, StandingWave) and not config.models:
        yield (
            "models: the force repeats along a standing wave, and formulas in x**2 + y**2 do not; "
            "add one with cos(4*pi*x/wavelength) (docs/reference/formulas.md)"
        )
    yield from unit_notes(config)


def unit_notes(config: FilmSections) -> Iterator[str]:
    """Notes on numbers without a unit that lie outside USUAL_RANGE_AND_INPUT_UNIT."""
    return _unit_notes_of_values(config.written_values, config.sections_as_dict())


def _unit_notes_of_values(
    written: Mapping[KeyPath, Any], sections: Mapping[str, Any]
) -> Iterator[str]:
    for place, value in written.items():
        unit = unit_of_schema(schema_of_key(place, sections))
        if unit in USUAL_RANGE_AND_INPUT_UNIT and isinstance(value, int | float):
            least, most, meant = USUAL_RANGE_AND_INPUT_UNIT[unit]
            if not least <= abs(value) <= most:
                key = ".".join(map(str, place))
                yield f"{key} is read as {value:g} {unit}; for {value:g} {meant} write the unit"


def target_force_notes(config: Study) -> Iterator[str]:
    """Yield a note where no amplitude of the screen gives the target force.

    As σ → ∞ a film with a parallel gap gives at most the force of a piston,
    p0 A (√((1 + 3/2 ε²)/(1 − ε²)) − 1), without inertia and thermal effects.
    """
    target, hv_m = config.extrapolation, config.screen.hv_m.stop
    ratio_squared = (hv_m / target.h0_m) ** 2
    if ratio_squared >= 1 or not config.pad.gap.flat:
        return
    pressure_ratio = math.sqrt((1 + 1.5 * ratio_squared) / (1 - ratio_squared)) - 1
    limit_n = config.gas.ambient_pressure_pa * config.pad.area_m2 * pressure_ratio
    if target.force_n > limit_n:
        yield (
            f"extrapolation.force: {target.force_n:g} N is beyond the screen: at h0 = "
            f"{1e6 * target.h0_m:g} µm and hv = {1e6 * hv_m:g} µm no film gives more than about "
            f"{limit_n:.2g} N without inertia and thermal effects; "
            "recommended amplitudes would not be validated"
        )


def value_origin(config: FilmSections, key_path: KeyPath) -> str:
    """Origin of a key's value, as a text; empty where it was written."""
    if key_path in config.written_values:
        return ""
    words = _schema_of_config_key(config, key_path).get("derived")
    return f"derived: {words}" if words else "default"


def _schema_of_config_key(config: FilmSections, key_path: KeyPath) -> Schema:
    return schema_of_key(key_path, config.sections_as_dict())


def _config_as_yaml_lines(
    values: Mapping[str, Any], key_path: KeyPath, config: FilmSections
) -> Iterator[str]:
    for name, value in values.items():
        here = (*key_path, name)
        start = "  " * len(key_path) + f"{_yaml_on_one_line(name)}:"
        if isinstance(value, Mapping) and value:
            yield start
            yield from _config_as_yaml_lines(value, here, config)
        else:
            notes = unit_of_schema(_schema_of_config_key(config, here)), value_origin(config, here)
            note = ", ".join(filter(None, notes))
            yield f"{start} {_yaml_on_one_line(value)}" + (f" # {note}" if note else "")


def _yaml_on_one_line(value: Any) -> str:
    """A value on one line."""
    text = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=10**6)
    return text.removesuffix("\n").removesuffix("\n...")


def write_effective_study(config: Study, folder: Path) -> Path:
    """Write the whole study beside its results, unless it is there; the file's path.

    Raises InputError where it cannot be written.
    """
    path, text = folder / STUDY_FILE_NAME, effective_yaml(config, folder=folder)
    same = path.exists() and read_text(path, what="study") == text
    # Who runs the study of an earlier run reads that very file.
    if not same and path.resolve() != config.path.resolve():
        write_text(text, path)
    return path


def write_study_file(values: Mapping[str, Any], *, results: Path) -> Path:
    """The file of a study that another workflow gives as a mapping: ``results``/STUDY/study.yaml.

    Commands read files, and so can a reader later. The study is checked as a file's is, and gets
    the same defaults. A measured profile's file counts from the working directory.
    Raises InputError naming the key that is wrong, or a file that cannot be written.
    """
    source = Path("the module's config")
    if not values:
        raise InputError(f"{source}: none; it must be a study (docs/reference/configuration.md)")
    try:
        plain = json.loads(json.dumps(values))
    except (TypeError, ValueError) as error:
        raise InputError(f"{source}: {error}") from None
    study = validated_sections(plain, path=source, model=Study)
    return write_effective_study(study, results / study.study)
