"""Who may do what: tokens, and the streams that end with them."""
