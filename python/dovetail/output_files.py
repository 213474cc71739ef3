"""Where the commands write."""

from pathlib import Path


def made(path):
    """The path of a file to write, whose folder is there. ValueError where it cannot be."""
    path = Path(path)
    refuse_folder(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"{path}: its folder is not there and cannot be made: {error.strerror}") from None
    return path


def refuse_folder(path):
    """ValueError where a folder has the name of a file to write."""
    if path.is_dir():
        raise ValueError(f"{path}: is there already and is a folder; name another with -o")
