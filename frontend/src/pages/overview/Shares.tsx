import { Anchor, Text } from "@mantine/core";
import { Fragment } from "react";
import { listGateways, type RunningGateway } from "../../api/gateways";
import { session } from "../../api/session";
import { useFleet, useWhyNot } from "../../fleet/context";
import { useAnswer } from "../../ui/requests";

const EVERY_MS = 10_000;

/** Which robots this gateway serves, and who serves the others; nothing where it serves every robot. */
export function Shares() {
  return session.state.share.length > 0 ? <Share robots={session.state.share} /> : null;
}

function Share({ robots }: { robots: readonly string[] }) {
  const { http } = useFleet();
  const { data: gateways = [] } = useAnswer({
    queryKey: ["gateways"],
    queryFn: () => listGateways(http),
    enabled: useWhyNot("GET /gateways") === null,
    refetchInterval: EVERY_MS,
  });
  return (
    <Text size="sm" c="dimmed">
      This gateway serves {robots.join(", ")}.
      {gateways
        .filter((gateway) => !gateway.this)
        .map((other) => (
          <Fragment key={other.id}>
            {" "}
            {other.robots.join(", ") || "Every robot"}: <Place gateway={other} />.
          </Fragment>
        ))}
    </Text>
  );
}

function Place({ gateway: { address, host } }: { gateway: RunningGateway }) {
  if (address === null) return <>a gateway on {host}</>;
  return (
    <>
      <Anchor href={address} inherit underline="always">
        {address}
      </Anchor>{" "}
      on {host}
    </>
  );
}
