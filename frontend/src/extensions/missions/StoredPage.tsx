import type { ClientError } from "@dock-gateway/client";
import { Anchor, Group, Skeleton, Stack } from "@mantine/core";
import type { UseQueryResult } from "@tanstack/react-query";
import type { ReactNode } from "react";
import { NavLink } from "react-router";
import { Trouble } from "../../ui/errors";
import { PageTitle } from "../../ui/Section";
import classes from "./missions.module.css";

const PAGES = [
  { path: "/ui/missions", name: "Missions" },
  { path: "/ui/missions/today", name: "Today" },
  { path: "/ui/missions/templates", name: "Templates" },
  { path: "/ui/missions/schedules", name: "Schedules" },
  { path: "/ui/missions/places", name: "Places" },
];

/** Leads to the pages about missions. */
export function MissionPages() {
  return (
    <Group component="nav" gap="md" aria-label="Missions">
      {PAGES.map(({ path, name }) => (
        <Anchor key={path} component={NavLink} to={path} end size="sm" className={classes.page ?? ""}>
          {name}
        </Anchor>
      ))}
    </Group>
  );
}

interface StoredPageProps<Entry> {
  title: string;
  /** What is listed: `templates`. */
  what: string;
  /** What adds one. */
  button: ReactNode;
  query: UseQueryResult<readonly Entry[], ClientError>;
  empty: ReactNode;
  children: (entries: readonly Entry[]) => ReactNode;
}

/** A page with a list of something that people store for missions. */
export function StoredPage<Entry>({ title, what, button, query, empty, children }: StoredPageProps<Entry>) {
  const { data, error, refetch } = query;
  return (
    <Stack gap="md">
      <PageTitle title={title}>{button}</PageTitle>
      <MissionPages />
      <Trouble what={`The ${what} could not be loaded`} error={error} onRetry={() => void refetch()} />
      {data === undefined ? (
        error === null && <Skeleton height={110} role="status" aria-label={`The ${what} are loading`} />
      ) : data.length === 0 ? (
        empty
      ) : (
        <Stack component="ul" gap="sm" m={0} p={0} aria-label={title}>
          {children(data)}
        </Stack>
      )}
    </Stack>
  );
}
