# From results to figures, tables and claims. A page of figures is one job; `snakemake fig08` draws
# the page that the figure is on.

# What a figure shows, by its place among the results.
FIGURES = {
    "figures/overview": "what the whole study does",
    "figures/error_map": "relative error over the whole space",
    "figures/force_map": "the force, and the amplitude for the wanted force",
    "figures/budget": "what the film equation itself leaves out of the force",
    "figures/response": "how the force follows an amplitude that changes",
    "figures/levitation": "the gap that carries a load, and the film's stiffness there",
    "figures/profile": "the measured profile and its residuals",
    "figures/uncertainty": "what would explain the difference from the paper's force",
    "figures/fig05": "the model of the vibration over the surface",
    "figures/fig06": "the same as a mesh",
    "figures/fig07": "the screen: the simulations of the first plan",
    "figures/fig08": "the model fitted to the screen",
    "figures/fig09": "where the searches for an optimal design end",
    "figures/fig10": "the first pattern of optimal points",
    "figures/fig11": "the second pattern of optimal points",
    "figures/fig12": "the optimal design in the space of the experiment",
    "figures/fig13": "the model fitted to the optimal design",
    "figures/fig14": "relative error of that model on the screen",
    "figures/fig15": "the positions of the finger with four factors",
    "figures/fig16": "the optimal design with four factors",
    "numerics/work_precision": "error against run time",
    "numerics/stability": "stiff and extreme films",
    **{f"models/{space}_errors": f"models compared, {of}" for space, of in MODEL_SPACES.items()},
    **{
        f"designs/optimal_{space}_sensitivity": f"where to simulate, {of}"
        for space, of in MODEL_SPACES.items()
    },
    **{f"refine/{space}_figure": f"models refined, {of}" for space, of in MODEL_SPACES.items()},
}
TWO_FACTOR_DESIGN = [
    "simulations/screen/forces.csv",
    "simulations/two_factor_design/forces.csv",
    "fits/screen.json",
    "fits/two_factor_design.json",
]
ON_ERROR_MAP = [f"validation/two_factor_design_on_error_map.{kind}" for kind in ("csv", "json")]
ON_SCREEN = [f"validation/two_factor_design_on_screen.{kind}" for kind in ("csv", "json")]
OF_PLAN = expand(
    "validation/{pair}.json",
    pair=[
        "four_factor_design_on_four_factor",
        "four_factor_design_distinct_on_four_factor",
        "four_factor_design_distinct_on_four_factor_control",
    ],
)
# The figures of each page, and the files that they are drawn from.
PAGES = {
    "study": (
        ["overview", "error_map", "budget", "response", "levitation"],
        [
            *TWO_FACTOR_DESIGN,
            *ON_ERROR_MAP,
            "simulations/error_map/forces.csv",
            *expand("simulations/extrapolation/{name}.csv", name=["film", "forces"]),
            *expand(
                "simulations/screen/{name}.csv",
                name=["scenes", "budget", "response", "gains", "levitation"],
            ),
            "simulations/four_factor/budget.csv",
        ],
    ),
    "force_map": (["force_map"], ["simulations/error_map/forces.csv", "models/recommended.csv"]),
    "uncertainty": (
        ["uncertainty"],
        ["tables/uncertainty.csv", "tables/uncertainty_curves.csv"],
    ),
    "two_factor": (
        [f"fig{number:02}" for number in range(5, 15)],
        [
            *TWO_FACTOR_DESIGN,
            *ON_SCREEN,
            "simulations/screen/scenes.csv",
            *expand(
                "designs/{name}",
                name=["two_factor.csv", "two_factor.json", "two_factor_searches.csv"],
            ),
        ],
    ),
    "four_factor": (
        ["fig15", "fig16"],
        [
            *expand("simulations/{plan}/scenes.csv", plan=["screen", "four_factor"]),
            *expand("designs/{name}.csv", name=["four_factor", "four_factor_distinct"]),
        ],
    ),
}
PAGES = {
    page: ([f"figures/{name}" for name in names], files)
    for page, (names, files) in PAGES.items()
    if page not in (["force_map"] if PAPER else ["uncertainty", "two_factor", "four_factor"])
}
# Figures of other stages, each on a page of its own.
OTHERS = {
    "numerics/work_precision": ["numerics/work_precision.csv"],
    "numerics/stability": ["numerics/stability.csv"],
    **({"figures/profile": ["figures/profile.csv", "profile/summary.json"]} if SCAN else {}),
}
for space in MODEL_SPACES:
    OTHERS[f"models/{space}_errors"] = [f"models/{space}.csv", f"models/{space}_errors.csv"]
    table = f"designs/optimal_{space}_sensitivity"
    OTHERS[table] = [f"{table}.csv"]
    OTHERS[f"refine/{space}_figure"] = [f"refine/{space}.csv"]
# Tables and claims of the paper rest on nearly everything.
OF_THE_PAPER = [
    *expand("simulations/{plan}/forces.csv", plan=["screen", "four_factor", "extrapolation"]),
    *expand("simulations/{plan}/scenes.csv", plan=["screen", "four_factor"]),
    "simulations/screen/timings.csv",
    "simulations/extrapolation/budget.csv",
    *expand("fits/{fit}.json", fit=MODEL_OF_FIT),
    "fits/screen_runs.csv",
    *expand("designs/{name}", name=["two_factor.csv", "two_factor.json", "four_factor.csv"]),
    *ON_SCREEN,
    "validation/screen_on_screen.json",
    *OF_PLAN,
]
TABLES = {
    "1": "parameters of the two-factor model",
    "2": "the space of the experiment with four factors",
    "3": "parameters of the four-factor model",
}
CATEGORIES = {
    "figures": "3 Figures",
    "numerics": "4 Numerics",
    "models": "6 Models",
    "designs": "7 Designs and refinement",
    "refine": "7 Designs and refinement",
}


for page, (places, files) in {
    **PAGES,
    **{"_".join(Path(place).parts): ([place], files) for place, files in OTHERS.items()},
}.items():

    rule:
        name:
            f"draw_{page}"
        input:
            expand("<results>/{file}", file=files),
            profile=SMOOTHED,
        output:
            [in_report(place) for place in places],
            expand("<results>/{place}.png", place=places),
            [f"<results>/check/{place}.plain.png" for place in places if page in PAGES],
            expand("<results>/{place}.csv", place=numbered(places)),
        params:
            study=sections(*CONFIG),
        message:
            f"Draw the figures of {page}"
        script:
            "../scripts/draw_figures.py"


# One short target a figure.
for page, (places, _) in PAGES.items():
    for place in places:

        rule:
            name:
                Path(place).name
            input:
                getattr(rules, f"draw_{page}").output,


rule figures:
    input:
        [getattr(rules, f"draw_{page}").output for page in PAGES],
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
                    f"report/table{number}.html",
                    "2 Tables",
                    caption="table",
                    table=number,
                    shows=shows,
                )
                for number, shows in TABLES.items()
            ],
            expand("<results>/claims.{format}", format=["csv", "md"]),
            expand("<results>/tables/table{number}.{format}", number=TABLES, format=["csv", "md"]),
        message:
            "The paper's tables and claims beside ours"
        script:
            "../scripts/paper_tables.py"
