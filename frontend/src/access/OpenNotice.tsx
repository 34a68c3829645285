import { Alert, Anchor, Code, Stack, Text } from "@mantine/core";
import { Link, useLocation } from "react-router";
import { type SessionState, useSession } from "../api/session";
import { pageSite } from "../api/site";
import { Command } from "../ui/CopyButton";
import { Kept, useKept } from "../ui/kept";

const ADD_ADMIN = "dock-gateway user create NAME --role admin";

/** Who may do what on this page, in a few words; null where the gateway has not said. */
export function accessWords({ open_to, principal }: SessionState): string | null {
  if (open_to === "machine") return "Open: no login on this machine";
  if (open_to === "network") return "Open to the network: no login";
  return principal === null || principal.name === null
    ? null
    : `Logged in as ${principal.name}, ${principal.role}`;
}

/** What it means that no login is needed, and what changes that; nothing where one is. */
export function OpenNotice() {
  const state = useSession();
  if (state.open_to === null) return null;
  const network = state.open_to === "network";
  return (
    <Alert color={network ? "red" : "gray"} title={accessWords(state)}>
      <Stack gap="xs" align="flex-start">
        <Text size="sm">
          {network
            ? "Everyone who reaches this gateway over the network may move its robots and release stops."
            : "Every program and every user of the gateway's machine may move its robots. Other machines cannot reach it."}{" "}
          To have it ask for a login, add an admin on its machine, set{" "}
          <Code>DOCK_GATEWAY_AUTHENTICATION=true</Code> and restart it:
        </Text>
        <Command line={ADD_ADMIN} what="the command that adds an admin" />
      </Stack>
    </Alert>
  );
}

/** The pages that say more. */
const WITH_NOTICE: ReadonlySet<string> = new Set(["/ui/users", "/ui/tokens"]);

/** Whether the warning was closed in this browser. */
const closed = new Kept(
  "dock-gateway-open-to-network",
  (text) => text === "closed",
  (value) => (value ? "closed" : ""),
);

/** Warns on every page, until it is closed, that everyone on the network may move the robots. */
export function OpenBanner() {
  const state = useSession();
  const isClosed = useKept(closed);
  const { pathname } = useLocation();
  if (state.open_to !== "network" || isClosed || WITH_NOTICE.has(pathname)) return null;
  return (
    <Alert
      color="red"
      title={accessWords(state)}
      withCloseButton
      closeButtonLabel="Close the warning"
      onClose={() => {
        closed.value = true;
      }}
    >
      <Text size="sm">
        Everyone who reaches this gateway may move its robots.{" "}
        {pageSite() === null && (
          <Anchor component={Link} to="/ui/users" inherit>
            What this means, and how to change it
          </Anchor>
        )}
      </Text>
    </Alert>
  );
}
