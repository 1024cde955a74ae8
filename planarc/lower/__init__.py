"""The flat model as scalar equations over one table of shared expressions; `pipeline` begins it."""
