"""Results shown: tables in files (`table`), pages (`page`), pictures (`picture`), all shapes of
which are known once (`marks`)."""
