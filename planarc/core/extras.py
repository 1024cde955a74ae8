"""Packages that planarc needs only for some of what it does."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from planarc.core.diagnostic import usage_error

_DISTRIBUTIONS = {"PIL": "pillow", "imageio_ffmpeg": "imageio-ffmpeg"}


def need(module: str, extra: str) -> Any:
    """An optional package, or UsageError C221 that says how to get it."""
    try:
        return import_module(module)
    except ImportError:
        name = module.partition(".")[0]
        raise usage_error(
            "C221",
            f"this needs `{_DISTRIBUTIONS.get(name, name)}`, which is not installed",
            hint=f"install it with `pip install 'planarc[{extra}]'`",
        ) from None
