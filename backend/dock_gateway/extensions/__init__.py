"""Features that can be taken out: each is a folder with an `extension.py`, and never imports another one."""
