"""The film marched through time on the device."""
