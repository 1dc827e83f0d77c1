# From results to figures, tables and claims. A page of figures is one job; `snakemake fig08` draws
# the page that the figure is on.

CATEGORIES = {
    "figures": CATEGORY["Figures"],
    "numerics": CATEGORY["Numerics"],
    "models": CATEGORY["Models"],
    "designs": CATEGORY["Designs and refinement"],
    "refine": CATEGORY["Designs and refinement"],
}
TWO_FACTOR_DESIGN = [
    *expand("simulations/{plan}/forces.csv", plan=["screen", "two_factor_design"]),
    *expand("fits/{fit}.json", fit=["screen", "two_factor_design"]),
]
ON_ERROR_MAP = expand("validation/two_factor_design_on_error_map.{kind}", kind=["csv", "json"])
ON_SCREEN = expand(
    "validation/{fit}_on_screen.{kind}", fit=FITS["two_factor"], kind=["csv", "json"]
)
# The figures of each page, and the files that they are drawn from.
PAGES = {
    "study": (
        ["overview", "forces", "error_map", "error_budget", "response", "levitation"],
        [
            *TWO_FACTOR_DESIGN,
            *ON_ERROR_MAP,
            "simulations/error_map/forces.csv",
            *expand("simulations/extrapolation/{name}.csv", name=["film", "forces"]),
            *expand("simulations/screen/{name}.csv", name=["scenes", *FILM_TABLES["screen"]]),
            "simulations/four_factor/error_budget.csv",
        ],
    ),
}
if PAPER:
    PAGES["two_factor"] = (
        [f"fig{number:02}" for number in range(5, 15)],
        [
            *TWO_FACTOR_DESIGN,
            *ON_SCREEN,
            "simulations/screen/scenes.csv",
            *expand("designs/two_factor{end}", end=[".csv", ".json", "_searches.csv"]),
        ],
    )
    PAGES["four_factor"] = (
        ["fig15", "fig16"],
        [
            *expand("simulations/{plan}/scenes.csv", plan=["screen", "four_factor"]),
            *expand("designs/{name}.csv", name=["four_factor", "four_factor_distinct"]),
        ],
    )
else:
    PAGES["model"] = (
        ["vibration", "fitted_model", "design"],
        [*TWO_FACTOR_DESIGN, "simulations/screen/scenes.csv", "designs/two_factor.csv"],
    )
    PAGES["models"] = (["amplitudes"], ["models/recommended.csv"])
PAGES = {
    page: ([f"figures/{name}" for name in names], files) for page, (names, files) in PAGES.items()
}
# Those that are checked against a reference, and have a short target; and those of other stages.
CHECKED = {place: page for page, (places, _) in PAGES.items() for place in places}
for name in ("work_precision", "stability", "published"):
    PAGES[name] = ([f"numerics/{name}"], [f"numerics/{name}.csv"])
if SCAN:
    PAGES["profile"] = (["figures/profile"], ["figures/profile.csv", "profile/summary.json"])
PAGES["measurements"] = (
    ["figures/measurements"],
    expand("measurements/{file}", file=["comparison.csv", "summary.json"]),
)
for page, place, files in (
    ("models", "models/{space}_errors", ["models/{space}.csv", "models/{space}_errors.csv"]),
    ("optimal", "designs/optimal_{space}_sensitivity", ["designs/optimal_{space}_sensitivity.csv"]),
    ("refine", "refine/{space}_figure", ["refine/{space}.csv"]),
):
    places, sources = PAGES.get(page, ([], []))
    PAGES[page] = (
        [*places, *expand(place, space=FITS)],
        [*sources, *expand(files, space=FITS)],
    )
PAGES["refine"][1].extend(
    file.removeprefix("<results>/") for space in FITS for file in refined_files(space)
)
# Tables and claims of the paper rest on nearly everything.
OF_THE_PAPER = [
    *expand("simulations/{plan}/forces.csv", plan=["screen", "four_factor", "extrapolation"]),
    *expand("simulations/{plan}/scenes.csv", plan=["screen", "four_factor"]),
    "simulations/screen/timings.csv",
    "simulations/extrapolation/error_budget.csv",
    *expand("fits/{fit}.json", fit=MODEL_OF_FIT),
    "fits/screen_runs.csv",
    *expand("designs/{name}", name=["two_factor.csv", "two_factor.json", "four_factor.csv"]),
    *ON_SCREEN,
    "validation/four_factor_design_on_four_factor.json",
    "validation/four_factor_design_distinct_on_four_factor.json",
    "validation/four_factor_design_distinct_on_four_factor_control.json",
]
TABLES = [1, 2, 3]


for page, (places, files) in PAGES.items():

    rule:
        name:
            f"draw_{page}"
        input:
            expand("<results>/{file}", file=files),
            profile=SMOOTHED,
        output:
            [drawing(place) for place in places],
            expand("<results>/{place}.png", place=places),
            [f"<results>/check/{place}.plain.png" for place in places if place in CHECKED],
            # The paper's numbered figures keep the table that they draw.
            [f"<results>/{place}.csv" for place in places if place.startswith("figures/fig")],
        log:
            f"<logs>/draw_{page}.log",
        localrule: True
        conda:
            "../../envs/workflow.yaml"
        params:
            code=code_of("figures", "draw_figures"),
            study=sections(),
        message:
            f"Draw the figures of {page}"
        script:
            "../scripts/draw_figures.py"


for place, page in CHECKED.items():

    rule:
        name:
            Path(place).name
        input:
            getattr(rules, f"draw_{page}").output,


rule figures:
    input:
        [getattr(rules, f"draw_{page}").output for page in dict.fromkeys(CHECKED.values())],
    message:
        "The study's figures are drawn"


if PAPER:

    rule paper_tables:
        input:
            expand("<results>/{file}", file=OF_THE_PAPER),
        output:
            listed(
                "report/claims.html",
                SUMMARY,
                page="2 Claims: the paper beside ours, each with a verdict",
                caption="claims",
            ),
            [
                listed(
                    f"report/table{number}.html", CATEGORY["Tables"], caption="table", table=number
                )
                for number in TABLES
            ],
            "<results>/claims.csv",
            expand("<results>/tables/table{number}.csv", number=TABLES),
        log:
            "<logs>/paper_tables.log",
        localrule: True
        conda:
            "../../envs/workflow.yaml"
        params:
            code=code_of("figures", "paper_tables"),
        message:
            "The paper's tables and claims beside ours"
        script:
            "../scripts/paper_tables.py"
