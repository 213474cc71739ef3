"""Pictures into files."""

from .letters import lend_letters


def save_picture(figure, path, **options):
    """Writes the figure, which pyplot then forgets: it keeps all that are not closed."""
    from matplotlib import pyplot

    lend_letters(figure)
    figure.savefig(path, **options)
    pyplot.close(figure)
