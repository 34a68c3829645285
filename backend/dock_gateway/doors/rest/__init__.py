"""The REST API of the operations that other doors have, too."""
