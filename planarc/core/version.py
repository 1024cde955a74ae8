"""The version of planarc, where a build of the package reads it, too."""

__version__ = "0.1.0"
