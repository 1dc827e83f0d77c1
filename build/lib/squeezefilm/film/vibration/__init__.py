"""Amplitude profiles: how a surface vibrates, by formula or as measured."""
