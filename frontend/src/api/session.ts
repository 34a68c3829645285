import type { components } from "@dock-gateway/client";
import { useSyncExternalStore } from "react";
import { OPERATIONS } from "./operations.gen";
import { apiPath, pageSite } from "./site";

/** On the page of a site: who is logged in at the server, and what the site lets them do. */
export interface SessionState
  extends Pick<Schema<"Session">, "required" | "open_to" | "principal" | "provider" | "share"> {
  /** Why this page does not reach its site; null where it does. */
  trouble?: Schema<"Problem"> | null;
}

type Schema<Name extends keyof components["schemas"]> = components["schemas"][Name];
type Principal = Schema<"Requester">;
export type Role = Schema<"Role">;

/** A page that got no answer is shown all the same: what needs a login is refused, and then it is asked again (ms). */
const ANSWER_MS = 3000;

/** The session before the gateway has said who is logged in. */
export const ANYBODY: SessionState = {
  required: false,
  open_to: null,
  principal: { name: null, kind: "anybody", role: "admin", robots: [], actions: [], topics: [] },
  provider: null,
  share: [],
};

/** Who uses this page, as the gateway says. The login itself is a cookie, which scripts cannot read. */
export class Session {
  #state = ANYBODY;
  #asking: Promise<void> | null = null;
  readonly #listeners = new Set<() => void>();

  get state(): SessionState {
    return this.#state;
  }

  /** Whether a login is needed first. */
  get loggedOut(): boolean {
    return this.#state.principal === null;
  }

  /** Takes what a login or a logout was answered. What was asked before it no longer counts. */
  set(state: SessionState): void {
    this.#asking = null;
    if (pageSite() === null || state.principal === null) this.#take(state);
    else void this.ask();
  }

  #take(state: SessionState): void {
    if (JSON.stringify(state) === JSON.stringify(this.#state)) return;
    this.#state = state;
    for (const listener of this.#listeners) listener();
  }

  /** Asks the gateway; without an answer it stays as it was. */
  readonly ask = (): Promise<void> => {
    if (this.#asking !== null) return this.#asking;
    const asking: Promise<void> = askServer()
      .then((state) => {
        if (state !== null && this.#asking === asking) this.#take(state);
      })
      .catch(() => {})
      .finally(() => {
        if (this.#asking === asking) this.#asking = null;
      });
    this.#asking = asking;
    return asking;
  };

  /** Asks the gateway after the login has changed: an answer that is still on its way is about the login before. */
  readonly askAgain = (): Promise<void> => {
    this.#asking = null;
    return this.ask();
  };

  /** Settles as soon as no login is needed any more. */
  async loggedIn(): Promise<void> {
    while (this.loggedOut) {
      await new Promise<void>((resolve) => {
        const stop = this.subscribe(() => {
          stop();
          resolve();
        });
      });
    }
  }

  readonly subscribe = (listener: () => void): (() => void) => {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  };
}

/** Who uses this page, and what they may do; null where the gateway gives no such answer. */
async function askServer(): Promise<SessionState | null> {
  const signal = AbortSignal.timeout(ANSWER_MS);
  const answer = await fetch("/session", { signal });
  if (!answer.ok) return null;
  const state = (await answer.json()) as SessionState;
  return pageSite() === null ? state : atSite(state, signal);
}

/** The login at the server with what the site lets them do; where it does not answer, as the server has it. */
async function atSite(state: SessionState, signal: AbortSignal): Promise<SessionState> {
  if (state.principal === null) return state;
  const answer = await fetch(apiPath("/session"), { signal }).catch(() => null);
  const document = await answer?.json().catch(() => null);
  if (answer?.ok !== true) return { ...state, trouble: (document ?? null) as Schema<"Problem"> | null };
  const { name, kind } = state.principal;
  return { ...state, principal: { ...(document as SessionState).principal, name, kind } as Principal };
}

/** Whether somebody of this kind may be logged in in several browsers. */
export function hasSession(kind: Principal["kind"] | undefined): boolean {
  return kind === "user" || kind === "person";
}

/** That of this page. */
export const session = new Session();

/** Who uses this page; re-renders when that changes. */
export function useSession(): SessionState {
  return useSyncExternalStore(session.subscribe, () => session.state);
}

/** Each role includes those before it. */
export const ROLES: readonly Role[] = ["viewer", "agent", "operator", "supervisor", "admin"];

/** A request that may need more than a login. */
export type Command = keyof typeof OPERATIONS;

/** Why the user of this page may not do something, in a sentence; null where they may. */
export function whyForbidden(command: Command): string | null {
  const { principal } = session.state;
  if (principal === null) return "Your login has ended. Log in first.";
  const [role, everyRobot] = OPERATIONS[command];
  if (ROLES.indexOf(principal.role) < ROLES.indexOf(role))
    // People are no agents.
    return `Needs the role ${role === "agent" ? "operator" : role}; you are ${principal.role}.`;
  const limited = principal.robots.length + principal.actions.length > 0;
  return limited && everyRobot ? "This is about every robot, and your access is limited to some." : null;
}

/** The answer of `whyForbidden`; re-renders when somebody else has logged in. */
export function useForbidden(command: Command): string | null {
  useSession();
  return whyForbidden(command);
}
