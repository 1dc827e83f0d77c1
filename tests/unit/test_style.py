"""Texts for readers keep to the words and the lengths that CONTRIBUTING names."""

import ast
import re
import runpy

import numpy as np
from PIL import Image

PRIVATE = re.compile(
    r"\b(left out|leaves? out|in all|two phases|two-phase|yardstick|dear|anew|judged?|bearable"
    r"|of its own|refused|refuses|beyond the equation|off by|left open|leaves? open|put back"
    r"|marched|bulg\w+|folded up|believed|good to)\b"
)
OPENING = re.compile(
    r"(What|Whether|How|Of|By|In|Where|Why|Which|Is|Those|That|Its|From|At|With)\b"
)
PARAGRAPH = re.compile(r"\n\n|\n(?= *(?:[\w, ]+:|-) )")
"""Between paragraphs of a docstring, or what its sections and lists have."""
ASIDE = re.compile(r"(?m)`[^`]*`|\$[^$]*\$|\]\([^)]*\)|\([^)]*\)|^\d\. |(?<=\d) (?=\d{3})")
"""Code, formulas, links, conditions in parentheses, numbers of a list, gaps in a number."""
RANGE = re.compile(r"(±|(?<=\d)(–| to |·10|/)|10(?=[⁻⁰¹²³⁴-⁹]))[ \d.·⁻⁰¹²³⁴-⁹]+")
"""The second of two numbers that are one quantity, and powers of ten."""


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
    """Return the private words of a paragraph, and its beginning if it is too full."""
    numbers = re.findall(r"(?<![\w.⁻-])\d[\d.]*", RANGE.sub("", ASIDE.sub("", part)))
    return PRIVATE.findall(part) + [part[:60]] * (len(part.split()) > 100 or len(numbers) > 3)


def test_a_page_is_short_and_in_the_words_of_the_field(repository):
    texts = pages(repository)
    faults = {place: [*filter(None, map(faults_of, prose(texts[place])))] for place in texts}
    assert not any(faults.values()), faults
    lengths = {place: len(text.split()) for place, text in texts.items()}
    assert lengths.pop(repository / "README.md") <= 650
    assert sum(lengths.values()) <= 16000


def test_every_picture_of_a_page_is_there_small_and_made_by_a_command(repository):
    shown = [
        (place.parent / name).resolve()
        for place, text in pages(repository).items()
        for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", text)
    ]
    assert not [picture for picture in shown if not picture.is_file()]
    made = runpy.run_path(str(repository / "docs" / "pictures.py"))
    known = {*made["PICTURES"]}
    kept = [path for path in (repository / "docs").rglob("*.png") if "_build" not in path.parts]
    assert {path.relative_to(repository / "docs").as_posix() for path in kept} <= known
    assert {path.resolve() for path in kept} == {*shown}
    assert max(path.stat().st_size for path in kept) < 150_000


def test_every_table_names_its_command_commit_and_date(repository):
    for path in (repository / "docs/data").glob("*.csv"):
        header = path.read_text(encoding="utf-8")
        assert all(f"# {name}: " in header for name in ("command", "commit", "date")), path


def test_light_areas_of_a_picture_stay_apart(repository, tmp_path):
    """Figure 14's grey band was lost in the white of its page."""
    pixels = np.full((200, 300, 3), 255, dtype=np.uint8)
    pixels[50:150] = 240
    pixels[:40] = np.random.default_rng(1).integers(0, 256, size=(40, 300, 3))
    picture = tmp_path / "picture.png"
    Image.fromarray(pixels).save(picture)
    runpy.run_path(str(repository / "docs" / "pictures.py"))["with_palette"](picture)
    shown = np.asarray(Image.open(picture).convert("RGB"))
    assert (shown[45, 0].tolist(), shown[100, 0].tolist()) == ([255] * 3, [240] * 3)


def test_a_docstring_opens_with_what_it_is_and_is_in_the_words_of_the_field(repository):
    kinds = ast.Module | ast.ClassDef | ast.FunctionDef
    trees = [ast.parse(place.read_text()) for place in (repository / "workflow").rglob("*.py")]
    nodes = [node for tree in trees for node in ast.walk(tree) if isinstance(node, kinds)]
    texts = [text for text in map(ast.get_docstring, nodes) if text]
    assert len(texts) > 1000
    assert not [text for text in texts if OPENING.match(text)]
    parts = [part.split() for text in texts for part in PARAGRAPH.split(text)]
    assert not [words for words in parts if len(words) > 100 or PRIVATE.search(" ".join(words))]
