"""Readers of foreign formats; each module offers convert(files, output) -> summary text."""

from . import csv

FORMATS = {"csv": csv.convert}
