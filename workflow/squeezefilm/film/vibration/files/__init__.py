"""Scans as vibrometers export them: tables of text, universal files."""
