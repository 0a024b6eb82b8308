"""What a user writes: the data model of a case, read from TOML or built in Python."""

from pellucid.case.memory import check_memory
from pellucid.case.reading import load, loads, located
from pellucid.case.schema import json_schema
from pellucid.case.settings import parse_setting, parse_value
from pellucid.case.spec import Case, EnergyCase, OutputCase, Probe, TimeCase, TimesCase
from pellucid.case.writing import dumps

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
