"""Commands that the rules call, one after another."""

COMMANDS = {
    "plan": "write the scenes of a plan",
    "extrapolate": "write the scenes at which fitted models expect a wanted force",
    "gather": "put the simulated parts of a plan together",
    "limits": "the physics limit of each scene, with nothing fitted",
    "limit-table": "the physics limit all over a study's space, as polynomials",
    "profile": "smooth a measured vibration profile and weigh its noise",
    "fit": "fit an empirical model to forces",
    "validate": "judge a fitted model on simulated forces",
    "design": "find the points at which simulations teach most about a fitted model",
    "optimal": "D-optimal designs with a certificate, and how good other plans are",
    "refine": "simulate, fit, design, until a model is good enough or cannot be",
    "warm": "compile the kernels ahead of time",
}
