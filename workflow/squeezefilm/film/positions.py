"""Pad positions of a study, in the form of its surface."""

from typing import Annotated

from pydantic import Field

from squeezefilm.sections import DERIVED, Different, Number, Section

UpTo100 = Field(min_length=1, max_length=100)
Distances = Annotated[list[Annotated[float, Number("m", 0, 10)]], UpTo100, Different]


class Positions(Section):
    """Pad positions of the four-factor plan, besides the centre: those written, on a disc in
    polar form, on a rectangle every x with every y; or so many `points` that fill the space up to
    the farthest of those written. The paper's Table II is not legible, so ours are assumed.

    Attributes:
        points: how many positions, the centre among them, that fill the reachable space (a
            scrambled Sobol' sequence, edges too), so that no wave of the profile can alias with
            them; default: 25 where no position is written and the study is not the paper's; else
            none
        phi_r_m: on a disc: distances of the pad's centre from the disc's; default: half of the
            way that the pad may go and stay on the disc, and all of it
        phi_deg: on a disc: directions. Those of 0 … 45 are enough: their mirror images are added as
            far as the scene lacks a square's symmetry (see below); default: 0, 22.5 and 45 on a
            disc
        x_m: on a rectangle: distances of the pad's centre from the y axis. Both sides of it are
            meant: images at −x are added unless pad and vibration make them the same; default: on a
            rectangle, 0, half of the way that the pad may go along x, and all of it
        y_m: the same along y; default: the same along y
    """

    points: Annotated[int, Field(strict=True, ge=4, le=1000)] = DERIVED
    phi_r_m: Annotated[
        list[Annotated[float, Number("m", 0, 10, open=True)]], UpTo100, Different
    ] = DERIVED
    phi_deg: Annotated[list[Annotated[float, Number("°", 0, 360)]], UpTo100, Different] = DERIVED
    x_m: Distances = DERIVED
    y_m: Distances = DERIVED
