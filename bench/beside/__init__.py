"""Parts of `side_by_side.py`: the problems, the other tools, timing."""
