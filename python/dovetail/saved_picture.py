"""Pictures into files."""


def save_picture(figure, path, **options):
    """Writes the figure, which pyplot then forgets: it keeps all that are not closed."""
    from matplotlib import pyplot

    figure.savefig(path, **options)
    pyplot.close(figure)
