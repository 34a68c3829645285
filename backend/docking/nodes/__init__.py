"""The programs that serve actions, and the simulator; one `main` each."""
