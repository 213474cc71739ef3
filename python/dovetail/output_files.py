"""Where the commands write."""

from pathlib import Path


def made(path):
    """The path of a file to write, whose folder is there. ValueError where it cannot be."""
    path = Path(path)
    refuse_no_file(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"{path}: its folder is not there and cannot be made: {error.strerror}") from None
    return path


def refuse_no_file(path):
    """ValueError where a folder or a symbolic link has the name of a file to write: what a link leads to may be anybody's."""
    if path.is_symlink():
        raise ValueError(f"{path}: is a symbolic link, and what it leads to would be replaced; name another with -o")
    if path.is_dir():
        raise ValueError(f"{path}: is there already and is a folder; name another with -o")
