"""The JSON schemas of the API, for the OpenAPI document."""
