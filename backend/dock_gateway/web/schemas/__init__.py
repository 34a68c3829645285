"""The JSON shapes of the API, for the OpenAPI document."""
