"""Commands that examine the solver: ``python -m verification COMMAND``."""

from squeezefilm.cli.main import main

GROUPS = {
    "The solver examined": {
        "verification.random_studies": "random-studies",
        "verification.modelling_errors": "modelling-errors auto-terms",
        "verification.estimates": "estimates guards stored-films",
        "verification.run_times": "run-times",
    },
    "Tables of the solver computed": {
        "verification.edge_layers": "edge-layers",
        "verification.second_order": "depth-averaged",
    },
}

if __name__ == "__main__":
    raise SystemExit(main(groups=GROUPS))
