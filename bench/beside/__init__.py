"""Code shared by the side-by-side benchmarks in Python."""
