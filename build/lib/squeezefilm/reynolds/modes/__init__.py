"""Pads and gaps that a grid does not know: the film in the modes of its pad."""
