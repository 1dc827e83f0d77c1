"""What the film equation leaves out: the size of each effect on the mean force, at first order."""
