"""Texts for readers keep to the words and the lengths that CONTRIBUTING names."""

import re

PRIVATE = re.compile(
    r"\b(left out|leaves? out|in all|two phases|two-phase|yardstick|dear|anew|judged?|bearable"
    r"|of its own|refused|beyond the equation|off by)\b"
)


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


def test_a_page_is_short_and_in_the_words_of_the_field(repository):
    texts = pages(repository)
    faults = [
        f"{place.relative_to(repository)}: {words}"
        for place, text in texts.items()
        for part in prose(text)
        for words in [match[0] for match in PRIVATE.finditer(part)]
        + ([f"{len(part.split())} words: {part[:60]}"] if len(part.split()) > 100 else [])
    ]
    assert not faults, "\n".join(faults)
    lengths = {place: len(text.split()) for place, text in texts.items()}
    assert lengths.pop(repository / "README.md") <= 650
    assert sum(lengths.values()) <= 15000
