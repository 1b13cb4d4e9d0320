"""The figures of a comparison: each file draws one into axes, and says whether it can."""
