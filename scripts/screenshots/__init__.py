"""Pictures of the dashboard's pages: for the documents, and to compare two revisions."""
