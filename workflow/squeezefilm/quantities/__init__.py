"""Quantities of a film: functions of the periodic states that ``solve`` kept."""
