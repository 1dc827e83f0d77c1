"""Other people's methods for the same film equation: the yardsticks of the OpenCL solver."""
