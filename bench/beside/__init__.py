"""What the side-by-side benchmarks in Python share."""
