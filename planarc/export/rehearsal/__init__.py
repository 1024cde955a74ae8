"""Runs by what leaves the house, in this process: what an FMU or a page will do, before it does.

library     the exported model as machine code for this processor, and its instances
run         a run of an instance as a result
"""
