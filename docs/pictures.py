"""Draw the pictures of the pages again (`make pictures`), from studies that are made first.

The numbered figures of the paper and those of its study come from `results/paper`; the other
pictures from the commands that their pages show.
"""

import subprocess
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

DOCS = Path(__file__).resolve().parent
COLOURS, AREA_COLOURS, WIDEST_PX = 256, 4, 800
FIGURES = {
    **{f"pictures/fig{number:02}.png": f"fig{number:02}" for number in range(5, 17)},
    "overview.png": "overview",
    "fitted_model.png": "fitted_model",
    "levitation.png": "levitation",
    "error_budget.png": "error_budget",
    "published.png": "numerics/published",
    "pictures/work_precision.png": "numerics/work_precision",
    "pictures/stability.png": "numerics/stability",
}
"""Figures of the paper's study, by their places in the docs."""
TABLES = {
    "profile": "squeezefilm profile --config config/my-actuator.yaml --table {table}",
    "curve": "squeezefilm simulate --h0 5:10:6um --hv 1um,1.5um,2um"
    " --config config/my-actuator.yaml --output {table}",
    "amplitude": "squeezefilm amplitude-for results/my-actuator/models/four_factor/limit_1.json"
    " --force 0.15N --h0 5:10:11um --x 0mm,2mm --output {table}",
    "levitation": "squeezefilm levitate --mass 40:100:7g --hv 2um,3um,4um"
    " --config config/levitation.yaml --output {table}",
}
"""Commands of the pages whose table is drawn by `squeezefilm plot`."""
PRESSURE = (
    "squeezefilm pressure --h0 5um --hv 2.2um --x 2mm --output {field} --config config/paper.yaml"
)
PICTURES = [*FIGURES, *(f"pictures/{name}.png" for name in (*TABLES, "pressure"))]


def run(command: str) -> None:
    """Run a command in the checkout, which must end well."""
    subprocess.run(["bash", "-c", command], cwd=DOCS.parent, check=True)


def with_palette(picture: Path) -> None:
    """Write a picture again, as wide as a page and with few colours: a fifth of the size.

    An octree keeps the colours of thin lines, which the median cut merges; it merges light areas,
    so that the commonest colours have a place of their own.
    """
    image = Image.open(picture).convert("RGB")
    image.thumbnail((WIDEST_PX, image.height))
    commonest = sorted(image.getcolors(image.width * image.height), reverse=True)[:AREA_COLOURS]
    octree = image.quantize(
        COLOURS - AREA_COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE
    )
    pixels, places, palette = np.asarray(image), np.array(octree), octree.getpalette()
    for _, colour in commonest:
        places[(pixels == colour).all(axis=2)] = len(palette) // 3
        palette += colour
    few = Image.fromarray(places)
    few.putpalette(palette)
    few.save(picture, optimize=True)


def main() -> None:
    """Make the studies, draw every picture, and reduce its colours."""
    for study in ("paper", "my-actuator"):
        run(f"[ -f config/{study}.yaml ] || squeezefilm new {study}")
    run("snakemake figures verification --configfile config/paper.yaml")
    run("snakemake models --configfile config/my-actuator.yaml")
    for place, figure in FIGURES.items():
        run(f"squeezefilm plot {figure} results/paper --output docs/{place}")
    with tempfile.TemporaryDirectory() as folder:
        for name, command in TABLES.items():
            table = f"{folder}/{name}.csv"
            run(command.format(table=table))
            words = "profile " * (name == "profile")
            run(f"squeezefilm plot {words}{table} --output docs/pictures/{name}.png")
        field = f"{folder}/field.nc"
        run(PRESSURE.format(field=field))
        run(f"squeezefilm plot-pressure {field} --output docs/pictures/pressure.png")
    for place in PICTURES:
        with_palette(DOCS / place)


if __name__ == "__main__":
    main()
