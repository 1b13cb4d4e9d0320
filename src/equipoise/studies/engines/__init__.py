"""Where the runs of a study run: processes of this machine, or a Dask cluster."""
