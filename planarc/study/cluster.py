"""The points of a study on a Dask cluster.

The compiled model is sent to each worker once. A bundle whose worker died is tried again
by Dask; if it keeps failing, its points are tried one by one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib import import_module
from typing import Any

from planarc.core.diagnostic import usage_error
from planarc.study.bundle import Outcome, Payload, Task, run_bundle


def on_cluster(
    client: Any, payload: Payload, bundles: Sequence[tuple[Task, ...]]
) -> Iterator[list[Outcome]]:
    """Outcomes as they come. `client` is a `distributed.Client`."""
    try:
        completed: Any = import_module("distributed").as_completed
    except ImportError:
        raise usage_error(
            "C221",
            "this needs `distributed`, which is not installed",
            hint="install it with `pip install 'dask[distributed]'`",
        ) from None
    shared = client.scatter(payload, broadcast=True, hash=False)
    waiting = list(bundles)
    while waiting:
        sent = {client.submit(run_bundle, shared, b, pure=False): b for b in waiting}
        waiting = []
        for future in completed(list(sent)):
            bundle = sent.pop(future)
            if future.status == "finished":
                yield future.result()
            elif len(bundle) > 1:
                waiting += [(task,) for task in bundle]
            else:
                reason = f"the worker failed: {future.exception()}"
                yield [Outcome(bundle[0].index, None, reason, lost=True)]
