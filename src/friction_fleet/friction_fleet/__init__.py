"""Many drives of many cars: bags to tables on a cluster, tables to a map of friction."""
