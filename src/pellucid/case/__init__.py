"""Data model of a case, read from TOML or built in Python."""

from pellucid.case.memory import check_memory
from pellucid.case.probe import Probe
from pellucid.case.reading import load, loads, located
from pellucid.case.settings import parse_setting, parse_value
from pellucid.case.spec import Case, EnergyCase, OutputCase, TimeCase, TimesCase, json_schema
from pellucid.case.toml import dumps

__all__ = [
    "Case",
    "EnergyCase",
    "OutputCase",
    "Probe",
    "TimeCase",
    "TimesCase",
    "check_memory",
    "dumps",
    "json_schema",
    "load",
    "loads",
    "located",
    "parse_setting",
    "parse_value",
]
