"""The black box: what was heard of a robot around each goal, as MCAP files."""
