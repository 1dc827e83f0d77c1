"""Commands that examine the solver: ``squeezefilm-verification COMMAND``."""

from squeezefilm.cli.main import main

COMMAND_GROUPS = {
    "The solver examined": {
        "squeezefilm_workflow.verification.random_studies": "random-studies",
        "squeezefilm_workflow.verification.edge_flow": "edge-flow",
        "squeezefilm_workflow.verification.modelling_errors": "modelling-errors auto-terms",
        "squeezefilm_workflow.verification.estimates": "estimates guards stored-films",
        "squeezefilm_workflow.verification.stability": "stability-plane",
        "squeezefilm_workflow.verification.run_times": "run-times",
    },
    "Tables of the solver computed": {
        "squeezefilm_workflow.verification.edge_layers": "edge-layers",
        "squeezefilm_workflow.verification.second_order": "depth-averaged",
    },
}


def verification() -> int:
    """Run one command that examines the solver and return its exit status."""
    return main(groups=COMMAND_GROUPS, program="squeezefilm-verification")


if __name__ == "__main__":
    raise SystemExit(verification())
