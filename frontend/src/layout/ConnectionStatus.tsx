import { Alert, Badge, Text, Tooltip } from "@mantine/core";
import { ofSites, serverName } from "../api/places";
import { useSession } from "../api/session";
import { pageSite } from "../api/site";
import { useFleetTopic } from "../fleet/context";
import type { ConnectionPhase } from "../stream/connection";
import { Time } from "../ui/Time";
import { sentence } from "../ui/text";
import classes from "./layout.module.css";

/** Only what is wrong has a colour. */
const PHASES: Record<
  ConnectionPhase | "logged out" | "site away",
  { label: string; color?: string; hint: string }
> = {
  connecting: { label: "connecting", hint: "Waiting for the gateway's first message." },
  live: { label: "live", hint: "What you see is what the gateway says now." },
  reconnecting: {
    label: "reconnecting",
    color: "orange",
    hint: "The connection to the gateway was lost; trying again by itself.",
  },
  "logged out": {
    label: "logged out",
    color: "orange",
    hint: "Your login has ended: nothing is live until you log in.",
  },
  "site away": {
    label: "site away",
    color: "red",
    hint: "The server does not reach the site, or does not let you see it; still trying.",
  },
  gone: {
    label: "gateway gone",
    color: "red",
    hint: "The gateway has not answered for 10 seconds or more; still trying.",
  },
};

export function ConnectionStatus() {
  const { phase } = useFleetTopic("connection");
  const { principal, trouble } = useSession();
  const away = trouble != null && phase !== "live";
  const { label, color, hint } = PHASES[principal === null ? "logged out" : away ? "site away" : phase];
  const words = (text: string) =>
    (ofSites() ? text.replace("gateway", serverName()) : text).replace("server", serverName());
  return (
    <Tooltip label={words(hint)} multiline maw={280}>
      <Badge
        variant={color === undefined ? "default" : "filled"}
        color={color ?? "gray"}
        className={classes.status}
        data-testid="connection"
        role="status"
      >
        {words(label)}
      </Badge>
    </Tooltip>
  );
}

/** Says, above everything, that what is below is not live. */
export function ConnectionBanner() {
  const { phase, since, reason } = useFleetTopic("connection");
  const { trouble } = useSession();
  const known = useFleetTopic("robots").size > 0;
  if (trouble != null && phase !== "live")
    return (
      <Alert color="red" title={`${pageSite()} cannot be reached`}>
        <Text size="sm">
          {sentence(trouble.detail)}.{" "}
          {known && (
            <>
              What you see below is what was known at <Time value={since} />.{" "}
            </>
          )}
          This page reconnects by itself. A Stop is repeated by the {serverName()} until the site confirms it.
        </Text>
      </Alert>
    );
  if (phase === "live" || phase === "connecting") return null;
  const gone = phase === "gone";
  const server = ofSites() ? serverName() : "gateway";
  return (
    <Alert
      color={gone ? "red" : "orange"}
      title={gone ? `The ${server} is gone` : `Reconnecting to the ${server}`}
    >
      <Text size="sm">
        What you see below is what was known at <Time value={since} />
        {reason !== null && `; the ${server} said: ${reason.replaceAll("_", " ")}`}. This page reconnects by
        itself.
        {gone &&
          " Check that dock-gateway runs (make run) and that this computer reaches it. Stop is still tried when you press it."}
      </Text>
    </Alert>
  );
}
