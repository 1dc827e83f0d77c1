"""Texts for readers keep to the words and the lengths that CONTRIBUTING names."""

import ast
import re

PRIVATE = re.compile(
    r"\b(left out|leaves? out|in all|two phases|two-phase|yardstick|dear|anew|judged?|bearable"
    r"|of its own|refused|refuses|beyond the equation|off by|left open|leaves? open|put back"
    r"|marched|bulg\w+|folded up|believed|good to)\b"
)
OPENING = re.compile(
    r"(What|Whether|How|Of|By|In|As|Where|Why|Which|Asked|If|When|Is|Are|Whose|Those|That|These|It"
    r"|Its|They|Their|To|From|Also|Here|For|At|With|Not|On|So|See|Have|Has)\b"
)
ASIDE = re.compile(
    r"`[^`]*`|\$[^$]*\$|\]\([^)]*\)|\([^)]*\)|^\d\. |(?<=\d) (?=\d{3})", re.MULTILINE
)
"""Code, formulas, links, conditions in parentheses, numbers of a list, gaps in a number."""
RANGE = re.compile(r"(±|(?<=\d)(–| to |·10|/)|10(?=[⁻⁰¹²³⁴-⁹]))[ \d.·⁻⁰¹²³⁴-⁹]+")
"""The second of two numbers that are one quantity, and powers of ten."""
NUMBER = re.compile(r"(?<![\w.⁻-])\d[\d.]*")


def pages(repository):
    """Return the hand-written pages of README, docs and config with their texts."""
    places = [repository / "README.md", *repository.glob("docs/**/*.md")]
    places += repository.glob("config/*.md")
    kept = [place for place in places if not {"_build", "_generated"} & {*place.parts}]
    return {place: place.read_text(encoding="utf-8") for place in kept}


def prose(text):
    """Return the paragraphs of a page without code, tables and lists."""
    text = re.sub(r"```.*?```|^(    |\$\$|\|).*?$", "", text, flags=re.DOTALL | re.MULTILINE)
    return [part for part in re.split(r"\n\s*\n", text) if not part.startswith(("- ", "#", "!"))]


def faults_of(part):
    """Return what style.md has against a paragraph."""
    numbers = NUMBER.findall(RANGE.sub("", ASIDE.sub("", part)))
    yield from (match[0] for match in PRIVATE.finditer(part))
    if len(part.split()) > 100:
        yield f"{len(part.split())} words: {part[:60]}"
    if len(numbers) > 3:
        yield f"numbers {', '.join(numbers)}: {part[:60]}"


def test_a_page_is_short_and_in_the_words_of_the_field(repository):
    texts = pages(repository)
    faults = [
        f"{place.relative_to(repository)}: {fault}"
        for place, text in texts.items()
        for part in prose(text)
        for fault in faults_of(part)
    ]
    assert not faults, "\n".join(faults)
    lengths = {place: len(text.split()) for place, text in texts.items()}
    assert lengths.pop(repository / "README.md") <= 650
    assert sum(lengths.values()) <= 15000


def test_a_docstring_opens_with_what_it_is_and_is_in_the_words_of_the_field(repository):
    nodes = ast.Module | ast.ClassDef | ast.FunctionDef
    texts = [
        (place, text)
        for place in (repository / "workflow").rglob("*.py")
        for node in ast.walk(ast.parse(place.read_text(encoding="utf-8")))
        if isinstance(node, nodes) and (text := ast.get_docstring(node))
    ]
    faults = [
        f"{place.relative_to(repository)}: {match[0]}: {text[:60]}"
        for place, text in texts
        if (match := OPENING.match(text) or PRIVATE.search(" ".join(text.split())))
    ]
    assert len(texts) > 1000
    assert not faults, "\n".join(faults)
