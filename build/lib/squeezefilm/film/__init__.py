"""What is simulated: a scene, its gas, pad and vibrating surface."""
