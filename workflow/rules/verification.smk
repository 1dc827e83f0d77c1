# Accuracy, run time and stability of the solver: `snakemake verification`. Not part of the paper.

# Each table with what it is, the sections beside the solver's and the files that it is made from.
NUMERICS = {
    "work_precision": (
        "Error against run time of the solver and of other methods",
        [],
        ["fits/screen.json"],
    ),
    "stability": ("Stiff and extreme films, each with a verdict", [], []),
    "ablation": (
        "What simplifications save, and that they cost no accuracy",
        FILM,
        expand("simulations/{plan}/scenes.csv", plan=["screen", "four_factor"]),
    ),
    "published": ("Published numbers beside exact solutions and the solver", [], []),
}
# Times are taken with nothing else running: such a rule asks for all cores.
TIMED = ["work_precision", "ablation"]


for table, (text, film, files) in NUMERICS.items():

    rule:
        name:
            table
        input:
            expand("<results>/{file}", file=files),
        output:
            f"<results>/numerics/{table}.csv",
        threads: workflow.cores or 1 if table in TIMED else 1
        resources:
            mem_mb=2000,
            runtime=30,
        params:
            code=CODE["verification"],
            study=sections("solver", "numerics", *film),
        message:
            text
        script:
            f"../scripts/{table}.py"


rule verification:
    input:
        expand("<results>/numerics/{table}.csv", table=NUMERICS),
        [pictures(f"numerics/{table}") for table in NUMERICS if table != "ablation"],
    message:
        "Accuracy, run time and stability of the solver are known"
