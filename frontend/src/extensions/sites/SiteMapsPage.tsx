import type { Robot } from "@dock-gateway/client";
import { Stack, Text } from "@mantine/core";
import { useEffect, useMemo, useRef, useState } from "react";
import { useFleetTopic } from "../../fleet/context";
import { byName } from "../../fleet/names";
import { isThere } from "../../fleet/words";
import { RobotsMap } from "../../pages/map/MapPage";
import { useFleetScenes } from "../../pages/map/scenes";
import { siteOf } from "../../pages/overview/list";
import { openStream, streamUrl } from "../../stream/stream";
import { PageTitle, Section } from "../../ui/Section";
import { watchSight } from "../../ui/sight";
import { hubName } from "./hub";

/** At a hub: a map for each site. */
export default function SiteMapsPage() {
  const robots = useFleetTopic("robots");
  const sites = useMemo(() => bySite([...robots.values()].filter(isThere)), [robots]);
  return (
    <Stack gap="md">
      <PageTitle title="Maps" help="extensions/sites#the-dashboard-of-a-hub" />
      {sites.length === 0 && <Text>No robot yet.</Text>}
      {sites.map(([site, robots]) => (
        <SiteMap key={site} site={site} robots={robots} />
      ))}
    </Stack>
  );
}

function bySite(robots: readonly Robot[]): [string, Robot[]][] {
  const sites = new Map<string, Robot[]>();
  for (const robot of robots) sites.set(siteOf(robot), [...(sites.get(siteOf(robot)) ?? []), robot]);
  return [...sites].sort(([one], [other]) => byName(one, other));
}

/** The map of a site, which is asked for while it is in sight. */
function SiteMap({ site, robots }: { site: string; robots: readonly Robot[] }) {
  const box = useRef<HTMLDivElement>(null);
  const scenes = useFleetScenes((robot) => hubName(site, robot));
  const [inSight, setInSight] = useState(false);
  useEffect(() => (box.current === null ? undefined : watchSight(box.current, setInSight)), []);
  useEffect(() => {
    if (!inSight) return;
    return openStream(streamUrl(window.location, scenes.query, `/sites/${site}/ws/feedback`), scenes);
  }, [inSight, scenes, site]);
  const away = robots.every((robot) => "site_state" in robot && robot.site_state !== "connected");
  return (
    <div ref={box}>
      {away ? (
        <Section title={site}>
          <Text>The site is not connected: where its robots are now is not known.</Text>
        </Section>
      ) : (
        <RobotsMap compact title={site} scenes={scenes} robots={robots} />
      )}
    </div>
  );
}
