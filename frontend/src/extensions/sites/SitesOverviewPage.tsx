import type { Robot } from "@dock-gateway/client";
import { useMemo } from "react";
import { AlertList } from "../../alerts/AlertList";
import { isThere } from "../../fleet/words";
import { overviewView } from "../../pages/overview/list";
import { Heading, WhenKnown } from "../../pages/overview/OverviewPage";
import RobotTable from "../../pages/overview/RobotTable";
import { useAddress } from "../../ui/address";
import SiteStrip from "./SiteStrip";

/** The robots of all sites of a hub. */
export default function SitesOverviewPage() {
  return <WhenKnown of={OfSites} />;
}

function OfSites({ robots }: { robots: ReadonlyMap<string, Robot> }) {
  const there = useMemo(() => [...robots.values()].filter(isThere), [robots]);
  const [{ group }] = useAddress(overviewView);
  return (
    <>
      <Heading />
      <AlertList group={group} />
      <SiteStrip />
      {there.length > 0 && <RobotTable robots={there} />}
    </>
  );
}
