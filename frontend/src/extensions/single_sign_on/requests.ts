import { type components, deadline, type Http, settle } from "@dock-gateway/client";

/** Somebody who is logged in with the identity provider. */
export type Person = components["schemas"]["Person"];

/** The people of the identity provider, sorted by name. */
export async function listPeople(http: Http): Promise<Person[]> {
  return (await settle(http.GET("/people", { signal: deadline() }))).people;
}

export async function endPersonSessions(http: Http, person: string): Promise<void> {
  await settle(
    http.DELETE("/people/{person}/sessions", { params: { path: { person } }, signal: deadline() }),
  );
}
