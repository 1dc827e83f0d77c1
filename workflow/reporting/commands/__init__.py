"""Commands that make figures and pages, and check a study."""

COMMANDS = {
    "figure": "build the table of a figure, and draw it",
    "plot": "draw a figure from its table again",
    "compare": "fitted models side by side: errors, a table and a map",
    "refine-report": "compare what a refinement estimated with points never seen",
    "cross-section": "gap and pressure along the middle of the finger over a period",
    "explorer": "write a page of HTML in which fitted models can be played with",
    "summary": "put a finished study on one page",
    "runs": "put the runs that made a study on one page",
    "pages": "turn Markdown into pages of HTML",
    "check": "compare a finished study with its stored reference",
    "verdict": "show the table of a check; fails when anything in it failed",
    "reference": "make the reference that a study is checked against",
}
