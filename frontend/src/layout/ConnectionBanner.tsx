import { Alert, Text } from "@mantine/core";
import { useFleetTopic } from "../fleet/context";
import { Time } from "../ui/Time";

/** Says, above everything, that what is below is not live. */
export function ConnectionBanner() {
  const { phase, since, reason } = useFleetTopic("connection");
  if (phase === "live" || phase === "connecting") return null;
  const gone = phase === "gone";
  return (
    <Alert
      color={gone ? "red" : "orange"}
      title={gone ? "The gateway is gone" : "Reconnecting to the gateway"}
    >
      <Text size="sm">
        What you see below is what was known at <Time value={since} />
        {reason !== null && `; the gateway said: ${reason.replaceAll("_", " ")}`}. This page reconnects by
        itself.
        {gone &&
          " Check that dock-gateway runs (make run) and that this computer reaches it. Stop is still tried when you press it."}
      </Text>
    </Alert>
  );
}
