"""The protocol's questions, each answered by one call of ours and turned by `convert`."""

from __future__ import annotations

from planarc.editor.peer import Peer


def register(peer: Peer) -> None:
    """Let a peer answer."""
