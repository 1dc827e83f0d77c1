"""The periodic state on the device: one launch, and the grids of a scene."""
