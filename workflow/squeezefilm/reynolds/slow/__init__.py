"""What the film does when its amplitude changes slowly against the vibration."""
