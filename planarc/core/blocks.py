"""Block lower triangular form: strongly connected components, in order of evaluation.

In:   successors   for each node the nodes that it needs
Out:  blocks       groups of nodes that need each other; a block comes after all it needs

Example: 0 needs 1, 1 and 2 need each other, 3 needs nothing.

    [[1], [2], [1], []]  ->  [[1, 2], [0], [3]]

Promises:  linear time, no recursion; nodes of a block in ascending order.
Reference: R. E. Tarjan, SIAM J. Comput. 1(2), 1972, 146-160.
"""

from __future__ import annotations

from collections.abc import Sequence


def sort_blocks(successors: Sequence[Sequence[int]]) -> list[list[int]]:
    count = len(successors)
    number = [-1] * count  # order of discovery
    low = [0] * count  # earliest node of the open path that is reachable
    open_ = [False] * count
    path: list[int] = []
    blocks: list[list[int]] = []
    found = 0
    for root in range(count):
        if number[root] >= 0:
            continue
        stack = [(root, 0)]
        while stack:
            node, position = stack.pop()
            if position == 0:
                number[node] = low[node] = found
                found += 1
                path.append(node)
                open_[node] = True
            else:
                low[node] = min(low[node], low[successors[node][position - 1]])
            while position < len(successors[node]):
                following = successors[node][position]
                position += 1
                if number[following] < 0:
                    stack.append((node, position))
                    stack.append((following, 0))
                    break
                if open_[following]:
                    low[node] = min(low[node], number[following])
            else:
                if low[node] == number[node]:
                    blocks.append(_close(node, path, open_))
    return blocks


def _close(root: int, path: list[int], open_: list[bool]) -> list[int]:
    """Take the finished component off the path."""
    block = []
    while True:
        node = path.pop()
        open_[node] = False
        block.append(node)
        if node == root:
            return sorted(block)
