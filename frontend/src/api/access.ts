import { type components, deadline, type Http, type paths, settle } from "@dock-gateway/client";
import { atServer } from "./site";
import { type Base, ifUnchanged } from "./version";

type Schemas = components["schemas"];

/** A token without its secret. */
export type Token = Schemas["Token"];
/** A new token with its secret, which only this answer has. */
export type CreatedToken = Schemas["CreatedToken"];
/** What a client says of a new token. */
export type TokenBody = paths["/tokens"]["post"]["requestBody"]["content"]["application/json"];

/** A person who logs in with a name and a password. */
export type User = Schemas["User"];
/** What an admin says of a user; a new one needs a password. */
export type UserBody = paths["/users/{user}"]["put"]["requestBody"]["content"]["application/json"];
/** A name and a password, or a token. */
export type LoginBody = paths["/session"]["post"]["requestBody"]["content"]["application/json"];

/** Logs this browser in; throws a ClientError with `invalid_login` or `invalid_token` where that is wrong. */
export function logIn(http: Http, body: LoginBody): Promise<Schemas["Session"]> {
  return settle(http.POST("/session", { body, signal: deadline(), ...atServer() }));
}

export function logOut(http: Http): Promise<Schemas["Session"]> {
  return settle(http.DELETE("/session", { signal: deadline(), ...atServer() }));
}

/** Logs out in every browser. */
export function logOutEverywhere(http: Http): Promise<Schemas["Session"]> {
  const params = { query: { everywhere: true } };
  return settle(http.DELETE("/session", { params, signal: deadline(), ...atServer() }));
}

/** Changes the own password; every other browser is logged out. */
export async function changePassword(http: Http, body: { old: string; new: string }): Promise<void> {
  await settle(http.PUT("/session/password", { body, signal: deadline(), ...atServer() }));
}

/** All users, sorted by name. */
export async function listUsers(http: Http): Promise<User[]> {
  return (await settle(http.GET("/users", { signal: deadline() }))).users;
}

/** Adds a user or changes one. @param base The user as they were read; null for a new one. */
export async function putUser(http: Http, name: string, body: UserBody, base: Base): Promise<void> {
  const params = { path: { user: name }, header: ifUnchanged(base) };
  await settle(http.PUT("/users/{user}", { params, body, signal: deadline() }));
}

export async function removeUser(http: Http, user: User): Promise<void> {
  const params = { path: { user: user.name }, header: ifUnchanged(user) };
  await settle(http.DELETE("/users/{user}", { params, signal: deadline() }));
}

export async function endSessions(http: Http, name: string): Promise<void> {
  await settle(
    http.DELETE("/users/{user}/sessions", { params: { path: { user: name } }, signal: deadline() }),
  );
}

/** All tokens, sorted by name. */
export async function listTokens(http: Http): Promise<Token[]> {
  return (await settle(http.GET("/tokens", { signal: deadline() }))).tokens;
}

export function createToken(http: Http, body: TokenBody): Promise<CreatedToken> {
  return settle(http.POST("/tokens", { body, signal: deadline() }));
}

export async function revokeToken(http: Http, id: string): Promise<void> {
  await settle(http.DELETE("/tokens/{token_id}", { params: { path: { token_id: id } }, signal: deadline() }));
}
