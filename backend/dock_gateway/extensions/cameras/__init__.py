"""The pictures of the robots' cameras, for browsers and video players."""
