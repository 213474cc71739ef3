"""Small changes to a file: bytes, and where it is text, numbers, words and lines."""

import re

NUMBERS = [b"0", b"-1", b"1", b"2", b"1.5", b"-0.0", b"2147483648", b"-2147483649", b"9223372036854775807", b"9223372036854775808",
           b"99999999999999999999", b"1" * 400, b"1e308", b"1e999", b"-1e999", b"1e-320", b"nan", b"inf", b"1d5", b"1_000", b"0x10", b"1.",
           b".", b"-", b"", "\u00b2".encode(), "\u0663".encode(), b"\xff", b"\0", b"true", b"*", b",", b'"', b"1e", b"1+5"]
NUMBER = re.compile(rb"[-+]?\.?\d[\d.]*(?:[eEdD][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_]+")


def _bytes(data, dice):
    at = dice.randrange(len(data) + 1)
    length = min(len(data) - at, dice.choice((1, 1, 2, 4, 8, 40)))
    piece = data[at:at + length]
    flipped = bytes(byte ^ 1 << dice.randrange(8) for byte in piece)
    new = dice.choice((b"", piece + piece, dice.randbytes(length), bytes(length), b"\xff" * length, flipped))
    return data[:at] + new + data[at + length:]


def _cut(data, dice):
    at = dice.randrange(len(data) + 1)
    return data[:at] if dice.random() < 0.7 else data[at:]


def _token(pattern, choices):
    def change(data, dice):
        found = list(pattern.finditer(data))
        if not found:
            return _bytes(data, dice)
        at, other = dice.choice(found), dice.choice(found)
        new = other[0] if dice.random() < 0.3 else dice.choice(choices)
        return data[:at.start()] + new + data[at.end():]
    return change


def _lines(data, dice):
    lines = data.splitlines(keepends=True)
    if len(lines) < 2:
        return _bytes(data, dice)
    i, j = dice.randrange(len(lines)), dice.randrange(len(lines))
    kind = dice.randrange(6)
    if kind == 0:
        del lines[i]
    elif kind == 1:
        lines.insert(j, lines[i])
    elif kind == 2:
        lines[i], lines[j] = lines[j], lines[i]
    elif kind == 3:
        del lines[min(i, j):max(i, j)]
    elif kind == 4:
        words = lines[i].split(b",")
        lines[i] = b",".join(words[:dice.randrange(len(words)) + 1]) + (b"\n" if dice.random() < 0.8 else b"")
    else:
        lines[i] = lines[i].rstrip() + dice.choice((b", ", b" 1", b",1,1,1,1", b",", b"=", b"\\", b"#")) + b"\n"
    return b"".join(lines)


CHANGES = (_bytes, _bytes, _cut, *3 * [_token(NUMBER, NUMBERS)], _token(WORD, [b"", b"X", b"x" * 300]), _lines, _lines)


def mutate(data, dice):
    """One to four changes; dice is a random.Random."""
    for _ in range(dice.choice((1, 1, 1, 2, 3, 4))):
        data = dice.choice(CHANGES)(data, dice)
    return data
