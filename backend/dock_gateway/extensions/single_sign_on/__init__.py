"""Single sign-on: people and services log in at an OpenID Connect provider."""
