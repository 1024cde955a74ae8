"""The page of `planarc serve`; what answers it is in `planarc/live`."""
