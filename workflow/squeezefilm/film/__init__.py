"""The simulated system: a scene, its gas, pad and vibrating surface."""
