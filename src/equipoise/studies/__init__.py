"""Many runs of a scenario: drawn, run on many cores, compared; gains that are found by them."""
