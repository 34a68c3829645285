import { Anchor, Badge, Skeleton, Stack, Table, Text, VisuallyHidden } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useQueryClient } from "@tanstack/react-query";
import { memo } from "react";
import { Link } from "react-router";
import { useSession } from "../../api/session";
import { useFleet, useFleetLive } from "../../fleet/context";
import { ageWords } from "../../fleet/words";
import { Dialog, QuestionBar } from "../../ui/Dialog";
import { CommandErrorAlert, Trouble } from "../../ui/errors";
import { fixed } from "../../ui/numbers";
import { ReasonButton } from "../../ui/ReasonButton";
import { useCommand } from "../../ui/requests";
import { PageTitle } from "../../ui/Section";
import { Time } from "../../ui/Time";
import { sentence } from "../../ui/text";
import { NoSites } from "./NoSites";
import { forgetSite, type Site } from "./requests";
import { clockWords, refusalWords, SITES_KEY, STATE_WORDS, sitePath, useSites } from "./sites";
import classes from "./sites.module.css";

/** Every site of the hub: whether it is connected, how current it is, and what was refused. */
export default function SitesPage() {
  const { data: sites, error, refetch } = useSites();
  return (
    <>
      <PageTitle title="Sites" help="extensions/sites#the-dashboard-of-a-hub" />
      <Trouble what="The sites could not be loaded" error={error} onRetry={() => void refetch()} />
      {sites === undefined ? (
        error === null && <Skeleton height={240} role="status" aria-label="The sites are loading" />
      ) : sites.length === 0 ? (
        <NoSites />
      ) : (
        <SitesTable sites={sites} />
      )}
    </>
  );
}

function SitesTable({ sites }: { sites: readonly Site[] }) {
  return (
    <Table verticalSpacing="xs" horizontalSpacing="sm" aria-label="Sites">
      <Table.Thead>
        <Table.Tr>
          <Table.Th>Site</Table.Th>
          <Table.Th>State</Table.Th>
          <Table.Th className={classes.number}>Robots</Table.Th>
          <Table.Th className={classes.number}>Goals</Table.Th>
          <Table.Th className={classes.number}>Alerts</Table.Th>
          <Table.Th visibleFrom="sm">Version</Table.Th>
          <Table.Th visibleFrom="md">Newest report</Table.Th>
          <Table.Th visibleFrom="md">Round trip</Table.Th>
          <Table.Th>
            <VisuallyHidden>Commands</VisuallyHidden>
          </Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {sites.map((site) => (
          <SiteRow key={site.name} site={site} />
        ))}
      </Table.Tbody>
    </Table>
  );
}

const COLORS: Record<Site["state"], string | null> = {
  connected: null,
  unreachable: "orange",
  refused: "red",
};

const SiteRow = memo(function SiteRow({ site }: { site: Site }) {
  const { name, state, changed_at, version, machine, lag_ms, round_trip_ms, stop } = site;
  const color = COLORS[state];
  return (
    <Table.Tr data-testid={`site ${name}`} className={classes.row}>
      <Table.Th scope="row">
        <Anchor component={Link} to={sitePath(name)} inherit fw={600}>
          {name}
        </Anchor>
        {machine !== "" && <div className={classes.quiet}>{machine}</div>}
      </Table.Th>
      <Table.Td>
        <Stack gap={2} align="flex-start">
          {color === null ? STATE_WORDS[state] : <Badge color={color}>{STATE_WORDS[state]}</Badge>}
          {stop.latched && <Badge color="red">{stopWords(site)}</Badge>}
          <span className={classes.quiet}>
            since <Time value={changed_at} />
          </span>
          <Notes site={site} />
        </Stack>
      </Table.Td>
      <Table.Td className={classes.number}>{site.robots}</Table.Td>
      <Table.Td className={classes.number}>{site.goals_running}</Table.Td>
      <Table.Td className={classes.number}>{site.alerts}</Table.Td>
      <Table.Td visibleFrom="sm">{version ?? "–"}</Table.Td>
      <Table.Td visibleFrom="md">{lag_ms === null ? "–" : ageWords(lag_ms)}</Table.Td>
      <Table.Td visibleFrom="md" className={classes.nowrap}>
        {round_trip_ms === null || state !== "connected" ? "–" : `${fixed(round_trip_ms, 1)} ms`}
      </Table.Td>
      <Table.Td>
        <Forget site={site} />
      </Table.Td>
    </Table.Tr>
  );
});

/** What is to be known of a site besides. */
function Notes({ site }: { site: Site }) {
  const { state, behind, detail } = site;
  const notes = [
    state === "connected" && behind ? "The hub still reads what it missed of this site" : null,
    state === "connected" ? clockWords(site) : null,
    state === "unreachable" ? "Robots are shown as they were; stops are repeated until they arrive" : null,
    detail,
    ...refusalWords(site),
  ].filter((note) => note !== null);
  return notes.map((note) => (
    <Text key={note} size="sm" className={classes.note ?? ""}>
      {sentence(note)}
    </Text>
  ));
}

function stopWords({ robots, stop }: Site): string {
  return stop.robots.length >= robots ? "Stopped" : `${stop.robots.length} of ${robots} stopped`;
}

/** Asks first: another gateway can take the name then. */
function Forget({ site: { name, state } }: { site: Site }) {
  const { http } = useFleet();
  const client = useQueryClient();
  const live = useFleetLive();
  const { principal } = useSession();
  const [asking, ask] = useDisclosure(false);
  const forget = useCommand(async () => {
    await forgetSite(http, name);
    await client.invalidateQueries({ queryKey: SITES_KEY });
  });
  if (principal?.role !== "admin") return null;
  const reason = !live
    ? "The hub is not connected."
    : forget.isPending
      ? "The hub has not answered yet."
      : state === "connected"
        ? "It is connected, and would be back at once. Shut its gateway down first."
        : null;
  return (
    <>
      <ReasonButton
        variant="subtle"
        size="compact-sm"
        reason={reason}
        aria-label={`Forget ${name} …`}
        onClick={ask.open}
      >
        Forget …
      </ReasonButton>
      <CommandErrorAlert command="Forget" error={forget.error} onClose={forget.reset} />
      <Dialog opened={asking} onClose={ask.close} title={`Forget ${name}?`}>
        <Stack gap="md">
          <Text size="sm">
            The site leaves this list, its robots leave the overview, and a stop that waits for it is no
            longer repeated. Its goals stay. Any gateway can then connect as {name}, and this one again, too.
          </Text>
          <QuestionBar
            keep="Keep it"
            onKeep={ask.close}
            go="Forget"
            onGo={() => {
              ask.close();
              forget.mutate();
            }}
          />
        </Stack>
      </Dialog>
    </>
  );
}
