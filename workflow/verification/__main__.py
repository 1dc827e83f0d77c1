"""Run the campaign of random studies: ``python -m verification random-studies``."""

from squeezefilm.cli.main import main

GROUPS = {"The solver examined": {"verification.random_studies": "random-studies"}}

if __name__ == "__main__":
    raise SystemExit(main(groups=GROUPS))
