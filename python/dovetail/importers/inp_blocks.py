"""The grammar of CalculiX and Abaqus input decks: keyword lines with parameters, and the data lines below them."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

MAX_DEPTH = 10  # of files that include files
LARGEST = 10**18  # whole numbers are below it, so that 64 bits hold them


@dataclass
class Block:
    """A keyword with its parameters and data lines; `places` holds the file and line of each, for messages."""

    keyword: str  # upper case, single blanks: "SOLID SECTION"
    parameters: dict  # upper-case name -> text as written; "" for one without a value
    place: tuple
    lines: list = field(default_factory=list)
    places: list = field(default_factory=list)

    def where(self, row=None):
        """"FILE, line N" of the keyword or of data line `row`."""
        path, number = self.place if row is None else self.places[row]
        return f"{path}, line {number}"

    def error(self, message, row=None):
        return ValueError(f"{self.where(row)}, *{self.keyword}: {message}")

    def needed(self, name):
        """A parameter that must be there."""
        if not self.parameters.get(name):
            raise self.error(f"wanted the parameter {name}=..., found {', '.join(self.parameters) or 'none'}")
        return self.parameters[name]

    def fields(self):
        """(row, [words]) of each data line; the empty word after a last comma is left out."""
        for row, line in enumerate(self.lines):
            words = [word.strip() for word in line.split(",")]
            while words and not words[-1]:
                words.pop()
            yield row, words

    def number(self, row, word, kind=float):
        """A word of data line `row` as a finite number; 1.5D3 is 1.5E3."""
        try:
            value = kind(word.upper().replace("D", "E") if kind is float else word)
        except ValueError:
            raise self.error(f"wanted a {'whole ' if kind is int else ''}number, found {word!r}", row) from None
        if kind is float and not np.isfinite(value):
            raise self.error(f"wanted a finite number, found {word}", row)
        if kind is int and abs(value) >= LARGEST:
            raise self.error(f"wanted a whole number of at most 18 digits, found {word[:30]}", row)
        return value

    def first_numbers(self):
        """The first word of every data line as a whole number."""
        return [self.number(row, words[0], int) for row, words in self.fields() if words]

    def table(self, width):
        """The data lines as a float array (lines, width); numbers left out are zero."""
        try:
            if all(line.count(",") == width - 1 for line in self.lines):
                table = np.array(",".join(self.lines).split(","), dtype=np.float64).reshape(-1, width)
                if np.isfinite(table).all():
                    return table
        except ValueError:
            pass  # an empty field, or one that the slow way below refuses by name
        table = np.zeros((len(self.lines), width))
        for row, words in self.fields():
            if len(words) > width:
                raise self.error(f"wanted at most {width} numbers, found {len(words)}", row)
            table[row, :len(words)] = [self.number(row, word or "0") for word in words]
        return table

    def records(self, width):
        """Whole numbers (records, width), one record on one line or several, and the data line each begins on."""
        lines = [line.rstrip().rstrip(",") for line in self.lines]
        ends = np.cumsum([line.count(",") + 1 for line in lines])
        wanted = np.arange(width, ends[-1] + width, width)
        there = np.isin(wanted, ends)
        starts = np.r_[0, np.searchsorted(ends, wanted)[:-1] + 1]
        if not there.all():
            first = int(np.argmin(there))
            raise self.error(f"wanted {width} numbers (its own and those of its nodes) for each element, found another count",
                             int(starts[first]))
        try:
            return np.array(",".join(lines).split(","), dtype=np.int64).reshape(-1, width), starts
        except (ValueError, OverflowError):
            for row, words in self.fields():
                for word in words:
                    self.number(row, word, int)
            raise


def read_blocks(path):
    """All blocks of a deck in order, with *INCLUDE and INPUT= followed.

    Parameters
    ----------
    path : str or Path
        The deck. Files that it names are sought beside the file that names them, then beside the deck.

    Raises
    ------
    ValueError
        For a file that is not there or includes itself, or data before any keyword.
    """
    blocks = []
    _read(Path(path), Path(path).parent, blocks, 0)
    if not blocks:
        raise ValueError(f"{path}: wanted an input deck, found no keyword (a line that begins with *)")
    return blocks


def _read(path, folder, blocks, depth):
    for number, line in _logical_lines(path):
        if not line.startswith("*"):
            if not blocks:
                raise ValueError(f"{path}, line {number}: wanted a keyword such as *NODE before the first data, found {line[:30]!r}")
            blocks[-1].lines.append(line)
            blocks[-1].places.append((str(path), number))
            continue
        keyword, *words = line[1:].split(",")
        parameters = {}
        for word in filter(str.strip, words):
            name, _, value = word.partition("=")
            parameters[" ".join(name.upper().split())] = value.strip().strip('"')
        block = Block(" ".join(keyword.upper().split()), parameters, (str(path), number))
        include = block.keyword == "INCLUDE"
        if not include:
            blocks.append(block)
        if include or parameters.get("INPUT"):
            name = block.needed("INPUT")
            named = [place / name for place in (path.parent, folder) if (place / name).is_file()]
            if not named:
                raise block.error(f"there is no file {name} beside it")
            if depth == MAX_DEPTH:
                raise block.error(f"files include each other more than {MAX_DEPTH} deep")
            _read(named[0], folder, blocks, depth + 1)


def _logical_lines(path):
    """(number, text) of the lines that count; a keyword line that ends with a comma goes on in the next line."""
    started, head = 0, ""
    with open(path, encoding="utf-8-sig", errors="replace") as stream:
        for number, line in enumerate(stream, start=1):
            line = line.strip()
            if not line or line.startswith("**"):
                continue
            if head:
                head += line
            elif line.startswith("*"):
                started, head = number, line
            else:
                yield number, line
                continue
            if not head.endswith(","):
                yield started, head
                head = ""
    if head:
        yield started, head
