"""The controllers of a study side by side: statistics, figures, tables, one page like a paper's."""
