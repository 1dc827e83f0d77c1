# The paper's study and the same one with inertia, side by side in both: `make paper-inertia`.

SIDES = ["paper", "paper-inertia"]
COMPARED = [*OF_THE_PAPER, *ON_ERROR_MAP, "designs/four_factor_distinct.csv"]
# A run makes the results of one study: those of the other must be there.
OTHER_TABLES = [f"results/{side}/{file}" for side in SIDES if side != STUDY for file in COMPARED]
BOTH_MADE = PAPER and STUDY in SIDES and all(Path(file).is_file() for file in OTHER_TABLES)


if BOTH_MADE:

    rule equations:
        input:
            expand("results/{side}/{file}", side=SIDES, file=COMPARED),
        output:
            csv="<results>/tables/equations.csv",
            page=listed(
                "report/equations.html",
                SUMMARY,
                page="4 Inertia: does the paper's conclusion survive?",
                caption="equations",
            ),
        log:
            "<logs>/equations.log",
        localrule: True
        conda:
            "../../envs/workflow.yaml"
        params:
            code=code_of("figures", "page"),
            page="equations",
            about={"sides": expand("results/{side}", side=SIDES)},
        message:
            "The paper's equation beside a gas that has inertia"
        script:
            "../scripts/page.py"
