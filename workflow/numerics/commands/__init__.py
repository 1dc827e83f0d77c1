"""Commands of the numerics stage."""

COMMANDS = {
    "work-precision": "error against run time of the solver and of other methods",
    "equal-error": "how many times less time the solver takes than other methods",
    "stability": "stiff and extreme films, each with a verdict",
    "cost": "run time and memory against the size of the problem",
    "conditioning": "how force errors move the fit and the design",
    "left-out": "put back what scenes do not need: the same forces, at what cost",
    "resolved-strip": "film equations on a strip beside one resolved across the gap",
    "roofline": "measure the solver's kernels beside the limits of the device",
}
