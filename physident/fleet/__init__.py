"""Many recordings of many arms: what has changed on each arm since its baseline, on a Dask cluster, kept as a data set.

``run`` maps ``work`` over the files that are new; ``changes`` measures the changes in one recording; ``drift`` reads the data set.
"""
