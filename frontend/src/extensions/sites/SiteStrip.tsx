import { Text } from "@mantine/core";
import { Link } from "react-router";
import { Trouble } from "../../ui/errors";
import { NoSites } from "./NoSites";
import type { Site } from "./requests";
import { countWords, STATE_WORDS, sitePath, urgentSites, useSites } from "./sites";
import classes from "./sites.module.css";

/** The number of sites that are shown; the page of sites has them all. */
const MOST = 8;

/** The sites at a glance, each leading to its dashboard. */
export default function SiteStrip() {
  const { data: sites, error, refetch } = useSites();
  if (sites === undefined)
    return <Trouble what="The sites could not be loaded" error={error} onRetry={() => void refetch()} />;
  if (sites.length === 0) return <NoSites />;
  const shown = urgentSites(sites).slice(0, sites.length > MOST ? MOST - 1 : MOST);
  return (
    <nav aria-label="Sites">
      <ul className={classes.strip}>
        {shown.map((site) => (
          <li key={site.name}>
            <SiteLink site={site} />
          </li>
        ))}
        {sites.length > MOST && (
          <li>
            <Link to="/ui/sites" className={classes.site}>
              <Text fw={600}>All {sites.length} sites</Text>
            </Link>
          </li>
        )}
      </ul>
    </nav>
  );
}

function SiteLink({ site }: { site: Site }) {
  const { name, state, stop } = site;
  return (
    <Link to={sitePath(name)} className={classes.site} data-state={state}>
      <span className={classes.name}>
        {name}
        {state !== "connected" && <span className={classes.away}>{STATE_WORDS[state]}</span>}
        {stop.latched && <span className={classes.stopped}>Stopped</span>}
      </span>
      <span className={classes.counts}>{countWords(site)}</span>
    </Link>
  );
}
