"""Analysis of a finished run, from its log: metrics, acceptance, figures."""
