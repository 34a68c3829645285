"""The programs that send goals."""
