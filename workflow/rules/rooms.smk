# What figures and tables say of themselves: each is a module, found in `figures` or `tables`.

from dataclasses import replace

from reporting.rooms import described, literal

CATEGORIES = {
    "figures": "3 Figures",
    "numerics": "4 Numerics",
    "models": "6 Models",
    "designs": "7 Designs and refinement",
    "refine": "7 Designs and refinement",
}
"""Of the report, by the folder that a figure lies in."""
# The paper has maps of its own, and no recommended model but its own.
NOT_OF_THE_PAPER = ["figures/force_map"]


def found_figures():
    """What every figure says of itself, by its place: one for each space where it has several."""
    packages = "*" if PAPER else "reporting"
    for path in sorted(LIBRARY.glob(f"{packages}/figures/[!_]*.py")):
        figure = described(path)
        if PAPER and figure.place in NOT_OF_THE_PAPER:
            continue
        if "{space}" not in figure.place:
            yield figure.place, figure
            continue
        for space, words in MODEL_SPACES.items():
            inputs = {name: file.format(space=space) for name, file in figure.inputs.items()}
            one = replace(figure, inputs=inputs, title=f"{figure.title}, {words}")
            yield one.place, one


try:
    FIGURES = dict(found_figures())
    TABLES = {
        path.stem.removeprefix("table"): described(path)
        for path in sorted(LIBRARY.glob("*/tables/[!_]*.py"))
    }
except InputError as error:
    refuse(error)
CLAIM_INPUTS = literal(LIBRARY / "paper" / "claims.py", "INPUTS")
# Those with a table of their own, and those drawn from a table that another stage makes.
OWN = [place for place, figure in FIGURES.items() if figure.builds]
STAGES = [place for place, figure in FIGURES.items() if not figure.builds]


def report_category(wildcards):
    return CATEGORIES[wildcards.place.partition("/")[0]]


def report_labels(wildcards):
    """How the report's list names a figure: the paper's by their numbers."""
    figure = FIGURES[wildcards.place]
    folder, _, name = wildcards.place.partition("/")
    if folder != "figures":
        return {"shows": figure.title}
    return {"figure": name.replace("fig", "Fig. ").replace("_", " "), "shows": figure.shows}


def among_results(inputs):
    """Files by name, where they lie."""
    return {name: f"<results>/{file}" for name, file in inputs.items()}


def named_inputs(inputs, files):
    """The words NAME=PATH of a command, of a figure's or a table's inputs."""
    return named([files[name] for name in inputs], names=inputs)
