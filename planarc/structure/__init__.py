"""A scalar model reduced to index 1 and sorted; `pipeline` names the passes in their order.

Graph algorithms (`matching`, `pantelides`, `blocks`, `tearing`) see integers only. `states` finds
the candidates for states; which of them are states is chosen while running (`solve/states`).
"""
