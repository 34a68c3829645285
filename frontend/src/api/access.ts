import { deadline, type Http, settle } from "./http";
import type { components, paths } from "./schema.gen";

type Schemas = components["schemas"];

/** A token without its secret. */
export type Token = Schemas["Token"];
/** A new token with its secret, which only this answer has. */
export type CreatedToken = Schemas["CreatedToken"];
/** What a client says of a new token. */
export type TokenBody = paths["/tokens"]["post"]["requestBody"]["content"]["application/json"];

/** Logs this browser in; throws a CommandError with `invalid_token` where the token is not valid. */
export function logIn(http: Http, token: string): Promise<Schemas["Session"]> {
  return settle(http.POST("/session", { body: { token }, signal: deadline() }));
}

export function logOut(http: Http): Promise<Schemas["Session"]> {
  return settle(http.DELETE("/session", { signal: deadline() }));
}

/** By name. */
export async function listTokens(http: Http): Promise<Token[]> {
  return (await settle(http.GET("/tokens", { signal: deadline() }))).tokens;
}

export function createToken(http: Http, body: TokenBody): Promise<CreatedToken> {
  return settle(http.POST("/tokens", { body, signal: deadline() }));
}

export async function revokeToken(http: Http, id: string): Promise<void> {
  await settle(http.DELETE("/tokens/{token_id}", { params: { path: { token_id: id } }, signal: deadline() }));
}
