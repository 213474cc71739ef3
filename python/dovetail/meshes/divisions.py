"""Arguments of the commands that make the models of inputs/."""

import argparse


def pair(text):
    """Two whole numbers from 1 on: "3x9"."""
    parts = text.split("x")
    if len(parts) != 2 or not all(part.isascii() and part.isdecimal() and int(part) > 0 for part in parts):
        raise argparse.ArgumentTypeError(f"two whole numbers from 1 on are wanted, such as 3x9, found {text!r}")
    return int(parts[0]), int(parts[1])
