# The paper's study and the same one with inertia, side by side in both: `make paper-inertia`.

SIDES = {side: f"results/{side}" for side in ("paper", "paper-inertia")}
COMPARED = literal(LIBRARY / "paper" / "equations.py", "INPUTS")
# A run makes the results of one study: those of the other must be there.
OTHERS = [
    f"{results}/{file}"
    for side, results in SIDES.items()
    if side != STUDY
    for file in COMPARED.values()
]
BOTH_MADE = PAPER and STUDY in SIDES and all(Path(file).is_file() for file in OTHERS)


if BOTH_MADE:

    rule equations:
        input:
            expand("{results}/{file}", results=SIDES.values(), file=COMPARED.values()),
        output:
            csv="<results>/tables/equations.csv",
            markdown="<results>/tables/equations.md",
        log:
            "<logs>/table/equations.log",
        localrule: True
        conda:
            "../../envs/fit.yaml"
        params:
            code=CODE["figures"],
            sides=list(SIDES.values()),
        message:
            "The paper's equation beside a gas that has inertia"
        shell:
            "python -m paper equations {params.sides:q} "
            "--output {output.csv:q} --markdown {output.markdown:q} >{log:q} 2>&1"

    use rule models_page as equations_page with:
        input:
            config=ancient(CONFIG_FILE),
            tables="<results>/tables/equations.md",
        output:
            report(
                "<results>/report/equations.html",
                category="1 Summary and claims",
                labels={"page": "4 Inertia: does the paper's conclusion survive?"},
                caption="../report/equations.rst",
            ),
        log:
            "<logs>/report/equations.log",
        localrule: True
        message:
            "The two equations as a page"
