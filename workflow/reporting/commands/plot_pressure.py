"""Pictures of a pressure field over the period, and an animation of it.

  squeezefilm pressure --h0 5um --hv 2.2um --x 1mm --output field.nc
  squeezefilm plot-pressure field.nc --output sheet.png film.gif

A name that ends in .gif makes the animation, one in .png, .svg or .pdf a sheet: the overpressure at
eight phases and in the mean, and its mean over the pad beside the gap there. The same field gives
the same files. Both need xarray: the extra `fields`.
"""

import argparse
from pathlib import Path

from squeezefilm.errors import InputError

FORMATS = (".png", ".svg", ".pdf", ".gif")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("field", metavar="FIELD.nc", help="by `squeezefilm pressure`")
    parser.add_argument("--output", required=True, nargs="+", type=Path, metavar="FILE")


def run(options: argparse.Namespace) -> None:
    for path in options.output:
        if path.suffix not in FORMATS:
            raise InputError(f"{path}: a picture's name ends in {', '.join(FORMATS)}")
    # matplotlib: only when something is drawn
    from reporting.figures import style
    from reporting.pressure_pictures import draw_sheet, read_field, save_animation

    field = read_field(options.field)
    sheets = [path for path in options.output if path.suffix != ".gif"]
    with style.settings():
        if sheets:
            style.save(draw_sheet(field), sheets)
        for path in options.output:
            if path.suffix == ".gif":
                save_animation(field, path)
